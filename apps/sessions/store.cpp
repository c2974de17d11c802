// SPDX-License-Identifier: Apache-2.0
#include "apps/sessions/store.h"

#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <tuple>
#include <utility>

#include "apps/common/directory.h"
#include "apps/common/paths.h"
#include "core/crc32c.h"
#include "core/file.h"
#include "core/text.h"

namespace im2fit::sessions {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kIdBytesMax = 40;
constexpr std::size_t kRandomLetters = 8;  // 40 bits: two sessions of one second are never of one id
constexpr mode_t kFolderMode = 0700, kFileMode = 0600;

Error system_error(const std::string& what, const std::string& path) {
  return {ErrorCode::io, what + " " + path + ": " + std::strerror(errno)};
}

Error unknown(const std::string& root, const std::string& id) {
  return {ErrorCode::not_found, fmt::format("no session is called {} in {}", id, root)};
}

std::string time_text(const char* form) {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), form, &utc)};
}

constexpr char kLetters[] = "abcdefghijkmnpqrstuvwxyz23456789";  // 32, none like another

Result<std::string> new_id() {
  std::array<unsigned char, kRandomLetters> random{};
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
    return system_error("cannot read", "random numbers");
  std::string id = time_text("%Y%m%d-%H%M%S-");
  for (const unsigned char byte : random) id += kLetters[byte % 32];
  return id;
}

// As new_id() makes them: "20260504-123000-abcdefgh".
bool is_own_id(std::string_view id) {
  constexpr std::string_view kForm = "dddddddd-dddddd-";
  if (id.size() != kForm.size() + kRandomLetters) return false;
  for (std::size_t i = 0; i < kForm.size(); ++i)
    if (kForm[i] == '-' ? id[i] != '-' : id[i] < '0' || id[i] > '9') return false;
  return id.find_first_not_of(kLetters, kForm.size()) == std::string_view::npos;
}

// "ID" of ".ID.part" and ".ID.gone", "" for other names. Only sessions made here are ever in ".ID.part": the folder
// may be a user's own, with the half of a download in it. Sessions from elsewhere may be in ".ID.gone".
std::string unfinished_id(const std::string& name) {
  constexpr std::size_t kEndBytes = 5;
  if (name.size() <= 1 + kEndBytes || name[0] != '.') return "";
  const std::string end = name.substr(name.size() - kEndBytes);
  const std::string id = name.substr(1, name.size() - 1 - kEndBytes);
  return (end == ".part" && is_own_id(id)) || (end == ".gone" && is_id(id)) ? id : "";
}

// What a program that was killed has left: its lock is free. The caller holds the root's.
void remove_left(const std::string& root) {
  std::error_code code;
  std::vector<fs::path> left;
  for (fs::directory_iterator it(root, code), end; !code && it != end; it.increment(code))
    if (!unfinished_id(it->path().filename().string()).empty()) left.push_back(it->path());
  for (const fs::path& path : left) {
    const Directory folder(path.string());
    if (folder.lock_if_free()) fs::remove_all(path, code);
  }
}

// Only its owner may read anything of it, whatever the umask was while it was written.
Status close_to_others(const std::string& folder) {
  std::error_code code;
  for (fs::recursive_directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
    if (it->is_symlink(code)) continue;
    const mode_t mode = it->is_directory(code) ? kFolderMode : kFileMode;
    if (::chmod(it->path().c_str(), mode) != 0) return system_error("cannot change the mode of", it->path().string());
  }
  if (code) return Error{ErrorCode::io, "cannot read " + folder + ": " + code.message()};
  return Ok{};
}

// Deleted while others were read; a link that leads nowhere is there.
bool is_gone(const fs::path& path) {
  std::error_code code;
  return fs::symlink_status(path, code).type() == fs::file_type::not_found;
}

}  // namespace

void sweep(const std::string& root) {
  if (const Directory held(root); held.lock()) remove_left(root);
}

std::string default_root() {
  return user_data_directory() + "/sessions";
}

bool is_id(std::string_view text) {
  return !text.empty() && text.size() <= kIdBytesMax &&
         text.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-") ==
             std::string_view::npos;
}

std::string digest_of(std::span<const std::byte> bytes) {
  return fmt::format("{:08x}", crc32c(bytes));
}

std::string utc_now() {
  return time_text("%Y-%m-%dT%H:%M:%SZ");
}

Status make_root(const std::string& root) {
  std::error_code code;
  const fs::path path(root);
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), code);
  if (!code && ::mkdir(root.c_str(), kFolderMode) != 0 && errno != EEXIST) return system_error("cannot make", root);
  return make_directory(root);
}

Result<NewSession> NewSession::begin(const std::string& root) {
  if (const auto made = make_root(root); !made) return made.error();
  auto id = new_id();
  if (!id) return id.error();
  const Directory held(root);  // a session's folder that was just made is not locked itself yet
  if (!held.lock()) return system_error("cannot lock", root);
  remove_left(root);
  NewSession session(root, *id, -1);
  if (::mkdir(session.folder_.c_str(), kFolderMode) != 0) return system_error("cannot make", session.folder_);
  Directory folder(session.folder_);
  if (!folder.lock_if_free()) {
    Error error = system_error("cannot lock", session.folder_);
    ::rmdir(session.folder_.c_str());
    return error;
  }
  session.lock_ = folder.release();
  return session;
}

NewSession::NewSession(NewSession&& other) noexcept
    : root_(std::move(other.root_)),
      id_(std::move(other.id_)),
      folder_(std::move(other.folder_)),
      lock_(std::exchange(other.lock_, -1)) {}

NewSession::~NewSession() {
  if (lock_ < 0) return;
  std::error_code code;
  fs::remove_all(folder_, code);
  ::close(lock_);
}

Status NewSession::write(const std::string& name, const std::string& text) const {
  return write_file_atomically(path(name), text, Readable::by_owner);
}

Status NewSession::finish(Record record) {
  record.id = id_;
  if (const std::string fault = fault_of(record); !fault.empty()) return Error{ErrorCode::invalid_argument, fault};
  if (const auto written = write(kRecordFile, record_json(record)); !written) return written.error();
  if (const auto closed = close_to_others(folder_); !closed) return closed.error();
  if (::fsync(lock_) != 0) return system_error("cannot write", folder_);
  const std::string final_folder = root_ + "/" + id_;
  if (::rename(folder_.c_str(), final_folder.c_str()) != 0) return system_error("cannot rename to", final_folder);
  ::close(std::exchange(lock_, -1));
  Directory(root_).sync();  // it is there in any case
  return Ok{};
}

Result<std::vector<Listed>> list(const std::string& root) {
  std::vector<Listed> all;
  std::error_code code;
  if (!fs::exists(root, code) && !code) return all;
  for (fs::directory_iterator it(root, code), end; !code && it != end; it.increment(code)) {
    const std::string id = it->path().filename().string();
    std::error_code fault;  // of this one alone: a link to itself, a disk that fails
    if (!is_id(id) || (!it->is_directory(fault) && !fault)) continue;
    if (fault) {
      if (is_gone(it->path())) continue;
      all.push_back({id, {}, fmt::format("{}/{}: {}", root, id, fault.message())});
      continue;
    }
    auto record = read(root, id);
    if (!record && is_gone(it->path())) continue;
    all.push_back(record ? Listed{id, std::move(*record), ""} : Listed{id, {}, record.error().message});
  }
  if (code) return Error{ErrorCode::io, "cannot read " + root + ": " + code.message()};
  std::sort(all.begin(), all.end(), [](const Listed& a, const Listed& b) {
    return std::tie(a.record.started_utc, a.id) < std::tie(b.record.started_utc, b.id);
  });
  return all;
}

Result<std::string> folder_of(const std::string& root, const std::string& id) {
  if (!is_id(id))
    return Error{ErrorCode::invalid_argument, "the id of a session has letters, digits, - and _, at most 40"};
  std::string folder = root + "/" + id;
  std::error_code code;
  if (!fs::is_directory(folder, code)) return unknown(root, id);
  return folder;
}

Result<Record> read(const std::string& root, const std::string& id) {
  const auto folder = folder_of(root, id);
  if (!folder) return folder.error();
  const std::string path = *folder + "/" + kRecordFile;
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes) return bytes.error();
  auto record = parse_record({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, path);
  if (record && record->id != id)
    return Error{ErrorCode::corrupt,
                 fmt::format("{}: id is \"{}\", expected the folder's name", path, excerpt(record->id))};
  return record;
}

Result<std::string> recording_of(const std::string& root, const std::string& id) {
  const auto folder = folder_of(root, id);
  if (!folder) return folder.error();
  std::error_code code;
  for (const char* name : {kRecordingFolder, kRecordingFile})
    if (fs::exists(*folder + "/" + name, code)) return *folder + "/" + name;
  return Error{ErrorCode::not_found, *folder + " has no recording"};
}

Status remove(const std::string& root, const std::string& id) {
  const auto folder = folder_of(root, id);
  if (!folder) return folder.error();
  const std::string going = root + "/." + id + ".gone";
  const Directory going_folder(*folder);
  (void)going_folder.lock_if_free();  // remove_left() leaves it alone
  {
    const Directory held(root);
    if (!held.lock()) return system_error("cannot lock", root);
    if (::rename(folder->c_str(), going.c_str()) != 0) {
      if (errno == ENOENT) return unknown(root, id);  // somebody else was first
      return system_error("cannot delete", *folder);
    }
  }
  // Without the lock, for which others wait to begin a session: the files may be many and the disk slow.
  std::error_code code;
  fs::remove_all(going, code);
  if (code) return Error{ErrorCode::io, "cannot delete all of " + going + ": " + code.message()};
  const Directory held(root);
  if (held.lock()) remove_left(root);
  held.sync();
  return Ok{};
}

}  // namespace im2fit::sessions
