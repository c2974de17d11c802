// SPDX-License-Identifier: Apache-2.0
// The folder of all sessions: ROOT/ID/ holds session.json, recording/ or recording.oni, result.json and joints.csv.
//
// A session appears whole or not at all: it is written in ROOT/.ID.part and renamed when everything is on the disk;
// it goes the same way, renamed to ROOT/.ID.gone and then deleted. What a program that was killed has left of either
// is deleted when the next session begins or goes, and when `im2fit serve --operator` starts. Folders are of mode
// 0700, files 0600. Several programs may use one root.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/sessions/record.h"

namespace im2fit::sessions {

inline constexpr char kRecordFile[] = "session.json";
inline constexpr char kRecordingFolder[] = "recording";
inline constexpr char kRecordingFile[] = "recording.oni";
inline constexpr char kResultFile[] = "result.json";
inline constexpr char kJointsFile[] = "joints.csv";

std::string default_root();         // ${XDG_DATA_HOME:-~/.local/share}/im2fit/sessions
bool is_id(std::string_view text);  // [A-Za-z0-9_-]{1,40}: also safe as a file's name
std::string utc_now();              // "2026-05-04T12:30:00Z"
// Makes the folder, readable by its owner alone, and its parents. Errors: io.
Status make_root(const std::string& root);
// As Versions has it: CRC-32C of a file, 8 hexadecimal digits. Errors: of opening it.
std::string digest_of(std::span<const std::byte> bytes);

// A session being written. Destroyed before finish() has succeeded it leaves nothing.
class NewSession {
 public:
  // Chooses the id, of the time and chance. Makes `root` and its parents. Errors: io.
  static Result<NewSession> begin(const std::string& root);
  NewSession(NewSession&& other) noexcept;
  NewSession& operator=(NewSession&&) = delete;
  ~NewSession();

  const std::string& id() const { return id_; }
  // Where to write the recording; its folder is not made.
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  Status write(const std::string& name, const std::string& text) const;
  // Writes session.json with this session's id; then it is complete. Errors: invalid_argument, as fault_of() says;
  // io, a full disk among it.
  Status finish(Record record);

 private:
  NewSession(std::string root, std::string id, int lock) : root_(std::move(root)), id_(std::move(id)), lock_(lock) {
    folder_ = root_ + "/." + id_ + ".part";
  }
  std::string root_, id_, folder_;
  int lock_;  // of the folder, while it is being written
};

// Deletes what programs that were killed have left. Sessions being written stay.
void sweep(const std::string& root);

struct Listed {
  std::string id;
  Record record;       // when it could be read
  std::string damage;  // else the fault, naming the file
};
// All sessions, the oldest first, damaged ones with their fault. A root that does not exist has none.
// Errors: io.
Result<std::vector<Listed>> list(const std::string& root);

// ROOT/ID. Errors: invalid_argument if `id` is not a session id; not_found.
Result<std::string> folder_of(const std::string& root, const std::string& id);
// Errors: as folder_of; as parse_record.
Result<Record> read(const std::string& root, const std::string& id);
// The depth folder or .oni of a session. Errors: as folder_of; not_found when it has none.
Result<std::string> recording_of(const std::string& root, const std::string& id);
// Everything of it. Errors: as folder_of; io.
Status remove(const std::string& root, const std::string& id);

}  // namespace im2fit::sessions
