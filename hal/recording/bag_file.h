// SPDX-License-Identifier: Apache-2.0
// The records of a rosbag, format 2.0 (http://wiki.ros.org/Bags/Format/2.0), in the order in which they stand.
// Messages are in chunks; one chunk is in memory at a time, and only where it is compressed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/status.h"
#include "hal/recording/file_cursor.h"

namespace im2fit::hal {

// Of a compressed chunk. Recorders begin another after 768 KiB and a message.
inline constexpr std::uint32_t kBagChunkMax = std::uint32_t{64} << 20;

struct BagConnection {
  std::string topic, type;
  std::int64_t message_count = 0;  // by the index
};

struct BagMessage {
  std::uint32_t connection = 0;
  std::int64_t time_ns = 0;
  FileCursor* data = nullptr;  // at the message's first byte; until the next call
  std::uint32_t size = 0;
};

class BagFile {
 public:
  // Errors: corrupt (no rosbag; one that was never closed), unsupported (version 1, more topics than a recording
  // has), io.
  static Result<std::unique_ptr<BagFile>> open(FileCursor file);

  const std::string& path() const { return file_.path(); }
  const std::map<std::uint32_t, BagConnection>& connections() const { return connections_; }
  void rewind();
  // None: there are no more. Errors: corrupt (a chunk is passed over, or nothing follows), unsupported (a
  // compression that is not in this build, or a chunk of more than kBagChunkMax; nothing follows), io.
  Result<std::optional<BagMessage>> next();

 private:
  struct Record {
    std::uint8_t op = 0;
    std::map<std::string, std::string> fields;
    std::uint32_t data_size = 0;
    std::uint64_t end = 0;  // of its data
  };
  explicit BagFile(FileCursor file) : file_(std::move(file)) {}
  Result<Record> read_record(FileCursor& cursor, std::uint64_t end) const;
  Status read_index();
  Status note_connection(const Record& record);
  void note_count(const Record& record);
  Status enter_chunk(const Record& record);
  Result<std::optional<BagMessage>> message_in(const Record& record);
  Error damaged(const std::string& problem) const;

  FileCursor file_;
  std::map<std::uint32_t, BagConnection> connections_;
  std::uint64_t first_record_at_ = 0, next_at_ = 0;  // of the records outside chunks
  std::vector<std::byte> unpacked_;
  std::optional<FileCursor> unpacked_cursor_;
  FileCursor* chunk_ = nullptr;  // none: outside chunks
  std::uint64_t chunk_at_ = 0, chunk_end_ = 0;
};

}  // namespace im2fit::hal
