// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/bag_file.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <utility>

#include "core/text.h"
#include "hal/recording/bag_chunk.h"

namespace im2fit::hal {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kHeaderMax = 65536;         // of a record; topics are short
constexpr std::uint32_t kDefinitionMax = 1U << 20;  // of a connection: its messages' definition
constexpr std::size_t kConnectionsMax = 10'000;
enum Op : std::uint8_t {
  message_data = 2,
  bag_header = 3,
  index_data = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7
};

std::uint64_t little_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

using RecordFields = std::map<std::string, std::string>;

// None: it is not there, or of another size.
std::optional<std::uint64_t> number_in(const RecordFields& fields, const char* name, std::size_t size) {
  const auto it = fields.find(name);
  if (it == fields.end() || it->second.size() != size) return std::nullopt;
  return little_endian(it->second);
}

// "name=value" with their lengths. False: they do not fill the text.
bool parse_fields(std::string_view text, RecordFields& fields) {
  while (!text.empty()) {
    if (text.size() < 4) return false;
    const std::uint64_t size = little_endian(text.substr(0, 4));
    text.remove_prefix(4);
    if (size > text.size()) return false;
    const std::string_view field = text.substr(0, static_cast<std::size_t>(size));
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) return false;
    fields.emplace(field.substr(0, equals), field.substr(equals + 1));
    text.remove_prefix(static_cast<std::size_t>(size));
  }
  return true;
}

Result<std::string> take_text(FileCursor& cursor, std::uint32_t size) {
  std::string text(size, '\0');
  if (auto ok = cursor.read(std::as_writable_bytes(std::span(text))); !ok) return ok.error();
  return text;
}

Result<std::uint32_t> take_u32(FileCursor& cursor) {
  const auto bytes = take_text(cursor, 4);
  if (!bytes) return bytes.error();
  return static_cast<std::uint32_t>(little_endian(*bytes));
}

}  // namespace

Error BagFile::damaged(const std::string& problem) const {
  return {ErrorCode::corrupt, file_.path() + ": " + problem + "; copy or record it again"};
}

Result<BagFile::Record> BagFile::read_record(FileCursor& cursor, std::uint64_t end) const {
  const auto header_size = take_u32(cursor);
  if (!header_size) return header_size.error();
  if (*header_size > kHeaderMax || *header_size > end - std::min(end, cursor.at()))
    return damaged("a record's head has " + std::to_string(*header_size) + " bytes");
  const auto header = take_text(cursor, *header_size);
  if (!header) return header.error();
  Record record;
  const auto data_size = take_u32(cursor);
  if (!data_size) return data_size.error();
  record.data_size = *data_size;
  record.end = cursor.at() + *data_size;
  if (record.end > end) return damaged("it ends within a record");
  const bool parsed = parse_fields(*header, record.fields);
  const auto op = number_in(record.fields, "op", 1);
  if (!parsed || !op) return damaged("a record's head is not a list of fields");
  record.op = static_cast<std::uint8_t>(*op);
  return record;
}

Result<std::unique_ptr<BagFile>> BagFile::open(FileCursor file) {
  std::unique_ptr<BagFile> bag(new BagFile(std::move(file)));
  FileCursor& cursor = bag->file_;
  cursor.seek(0);
  const auto magic = cursor.size() < kMagic.size() ? Result(std::string()) : take_text(cursor, kMagic.size());
  if (!magic) return magic.error();
  if (*magic != kMagic && magic->rfind("#ROSBAG V1", 0) == 0)
    return Error{ErrorCode::unsupported, bag->path() + " is a rosbag of format 1; convert it by: rosbag fix"};
  if (*magic != kMagic)
    return Error{ErrorCode::corrupt,
                 bag->path() + " is not a rosbag of ROS 1 (#ROSBAG V2.0); copy or record it again"};
  bag->first_record_at_ = cursor.at();
  if (auto ok = bag->read_index(); !ok) return ok.error();
  bag->rewind();
  return bag;
}

// Behind the chunks are the connections, and behind each chunk is how many messages of which connection it has.
// Nothing is decompressed for them.
Status BagFile::read_index() {
  const auto not_closed = [&] {
    return Error{ErrorCode::corrupt, path() +
                                         " has no index: it was cut off, or its recorder was; mend it by: rosbag "
                                         "reindex FILE"};
  };
  while (file_.left() > 0) {
    const auto record = read_record(file_, file_.size());
    if (!record) return record.error().code == ErrorCode::corrupt ? not_closed() : record.error();
    if (record->op == bag_header && number_in(record->fields, "index_pos", 8).value_or(0) == 0) return not_closed();
    if (record->op == connection)
      if (auto ok = note_connection(*record); !ok) return ok;
    if (record->op == index_data) note_count(*record);
    file_.seek(record->end);
  }
  if (std::none_of(connections_.begin(), connections_.end(), [](const auto& c) { return !c.second.topic.empty(); }))
    return not_closed();
  return Ok{};
}

Status BagFile::note_connection(const Record& record) {
  const auto id = number_in(record.fields, "conn", 4);
  const auto topic = record.fields.find("topic");
  if (!id || topic == record.fields.end() || record.data_size > kDefinitionMax)
    return damaged("a connection has no topic");
  if (connections_.size() == kConnectionsMax)
    return Error{ErrorCode::unsupported, path() + " has more than " + std::to_string(kConnectionsMax) + " topics"};
  const auto data = take_text(file_, record.data_size);
  if (!data) return data.error();
  RecordFields about;
  if (!parse_fields(*data, about)) return damaged("a connection is not a list of fields");
  BagConnection& connection = connections_[static_cast<std::uint32_t>(*id)];
  connection.topic = topic->second;
  connection.type = about["type"];
  return Ok{};
}

void BagFile::note_count(const Record& record) {
  const auto id = number_in(record.fields, "conn", 4), count = number_in(record.fields, "count", 4);
  if (!id || !count || (connections_.size() == kConnectionsMax)) return;
  connections_[static_cast<std::uint32_t>(*id)].message_count += static_cast<std::int64_t>(*count);
}

void BagFile::rewind() {
  next_at_ = first_record_at_;
  chunk_ = nullptr;
}

Status BagFile::enter_chunk(const Record& record) {
  const auto compression = record.fields.find("compression");
  const auto size = number_in(record.fields, "size", 4);
  if (compression == record.fields.end() || !size) return damaged("a chunk has no size");
  if (compression->second == "none") {
    chunk_ = &file_;
    chunk_at_ = file_.at();
    chunk_end_ = record.end;
    return Ok{};
  }
  if (auto ok =
          unpack_chunk(file_, record.data_size, compression->second, static_cast<std::uint32_t>(*size), unpacked_);
      !ok)
    return ok;
  unpacked_cursor_.emplace(unpacked_, path());
  chunk_ = &*unpacked_cursor_;
  chunk_at_ = 0;
  chunk_end_ = unpacked_.size();
  return Ok{};
}

Result<std::optional<BagMessage>> BagFile::message_in(const Record& record) {
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  const auto id = number_in(record.fields, "conn", 4), time = number_in(record.fields, "time", 8);
  if (!id || !time) return damaged("a message has no time");
  const auto seconds = static_cast<std::int64_t>(*time & 0xFFFFFFFFU);
  const auto rest = static_cast<std::int64_t>(*time >> 32);
  return std::optional(
      BagMessage{static_cast<std::uint32_t>(*id), seconds * kNsPerS + rest, chunk_, record.data_size});
}

Result<std::optional<BagMessage>> BagFile::next() {
  for (;;) {
    if (chunk_ != nullptr && chunk_at_ < chunk_end_) {
      chunk_->seek(chunk_at_);
      auto record = read_record(*chunk_, chunk_end_);
      auto message = !record                      ? Result<std::optional<BagMessage>>(record.error())
                     : record->op == message_data ? message_in(*record)
                                                  : std::optional<BagMessage>();
      chunk_at_ = message ? record->end : chunk_end_;  // the rest of a damaged chunk is passed over
      if (!message || *message) return message;
      continue;
    }
    chunk_ = nullptr;
    file_.seek(next_at_);
    if (file_.left() == 0) return std::optional<BagMessage>();
    const auto record = read_record(file_, file_.size());
    next_at_ = record ? record->end : file_.size();
    if (!record) return record.error();
    if (record->op != chunk) continue;
    if (auto ok = enter_chunk(*record); !ok) {
      if (ok.error().code != ErrorCode::corrupt) next_at_ = file_.size();
      return ok.error();
    }
  }
}

}  // namespace im2fit::hal
