// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/matroska.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <utility>

#include "core/file.h"
#include "core/text.h"

namespace im2fit::hal {
namespace {

// RFC 9559, section 5.
enum class Id : std::uint32_t {
  ebml = 0x1A45DFA3,
  doc_type = 0x4282,
  segment = 0x18538067,
  info = 0x1549A966,
  timestamp_scale = 0x2AD7B1,
  tracks = 0x1654AE6B,
  track_entry = 0xAE,
  track_number = 0xD7,
  track_uid = 0x73C5,
  track_type = 0x83,
  track_name = 0x536E,
  codec_id = 0x86,
  codec_private = 0x63A2,
  video = 0xE0,
  pixel_width = 0xB0,
  pixel_height = 0xBA,
  colour_space = 0x2EB524,
  content_encodings = 0x6D80,
  attachments = 0x1941A469,
  attached_file = 0x61A7,
  file_name = 0x466E,
  file_data = 0x465C,
  file_uid = 0x46AE,
  tags = 0x1254C367,
  tag = 0x7373,
  targets = 0x63C0,
  tag_track_uid = 0x63C5,
  tag_attachment_uid = 0x63C6,
  simple_tag = 0x67C8,
  tag_name = 0x45A3,
  tag_string = 0x4487,
  cluster = 0x1F43B675,
  timestamp = 0xE7,
  simple_block = 0xA3,
  block_group = 0xA0,
  block = 0xA1,
};

constexpr std::size_t kTextMax = 4096;     // of a name, a tag, a codec's header
constexpr std::size_t kEntriesMax = 1000;  // tracks, tags or attachments
constexpr int kElementsMax =
    50'000'000;  // outside clusters, or in ones without a size; a day of pictures has 3 million
constexpr std::uint64_t kTimeMax = 1ULL << 62;

struct Element {
  Id id{};
  std::optional<std::uint64_t> size;  // none: not known when it was written
};

Error damaged(const FileCursor& file, const std::string& problem) {
  return {ErrorCode::corrupt,
          file.path() + ": " + problem + " at byte " + std::to_string(file.at()) + "; copy or record it again"};
}

// A number whose first byte tells its length by the place of its highest bit, which is `kept` or not.
struct Varint {
  std::uint64_t value = 0;
  bool all_ones = false;
};
Result<Varint> read_varint(FileCursor& file, int bytes_max, bool kept) {
  std::array<std::byte, 8> bytes{};
  if (auto ok = file.read(std::span(bytes).first(1)); !ok) return ok.error();
  const auto first = std::to_integer<unsigned>(bytes[0]);
  int length = 1;
  while (length <= bytes_max && (first & (0x100U >> length)) == 0) ++length;
  if (length > bytes_max) return damaged(file, "invalid data");
  const auto rest = static_cast<std::size_t>(length - 1);
  if (auto ok = file.read(std::span(bytes).subspan(1, rest)); !ok) return ok.error();
  const unsigned marker = 0x100U >> length;
  Varint out{kept ? first : first & (marker - 1), (first & (marker - 1)) == marker - 1};
  for (std::size_t i = 1; i <= rest; ++i) {
    out.value = out.value << 8 | std::to_integer<std::uint64_t>(bytes[i]);
    out.all_ones = out.all_ones && bytes[i] == std::byte{0xFF};
  }
  return out;
}

Result<Element> read_element(FileCursor& file) {
  const auto id = read_varint(file, 4, true);
  if (!id) return id.error();
  const auto size = read_varint(file, 8, false);
  if (!size) return size.error();
  Element element{static_cast<Id>(id->value), std::nullopt};
  if (!size->all_ones) element.size = size->value;
  return element;
}

bool may_have_no_size(Id id) {
  return id == Id::segment || id == Id::cluster;
}

Result<std::uint64_t> read_number(FileCursor& file, std::uint64_t size) {
  std::array<std::byte, 8> bytes{};
  if (size > bytes.size()) return damaged(file, "a number of " + std::to_string(size) + " bytes");
  const auto used = std::span(bytes).first(static_cast<std::size_t>(size));
  if (auto ok = file.read(used); !ok) return ok.error();
  std::uint64_t value = 0;
  for (const std::byte b : used) value = value << 8 | std::to_integer<std::uint64_t>(b);
  return value;
}

Result<std::string> read_bytes(FileCursor& file, std::uint64_t size, std::size_t size_max) {
  if (size > size_max)
    return damaged(file,
                   "a text of " + std::to_string(size) + " bytes, expected at most " + std::to_string(size_max));
  std::string text(static_cast<std::size_t>(size), '\0');
  if (auto ok = file.read(std::as_writable_bytes(std::span(text))); !ok) return ok.error();
  return text;
}

Result<std::string> read_text(FileCursor& file, std::uint64_t size) {
  auto text = read_bytes(file, size, kTextMax);
  if (text) text->resize(std::min(text->find('\0'), text->size()));  // padding
  return text;
}

// Elements are taken in the order in which they stand. Groups whose entries are of interest are entered and others
// passed over, so no group needs an end.
class HeadReader {
 public:
  explicit HeadReader(FileCursor& file) : file_(file) {}

  Result<MatroskaHead> read() {
    file_.seek(0);
    const auto first = read_element(file_);
    if (!first || first->id != Id::ebml)
      return Error{ErrorCode::corrupt, file_.path() + " is not a Matroska file; copy or record it again"};
    for (int count = 0; file_.left() > 0; ++count) {
      if (count == kElementsMax)
        return Error{ErrorCode::unsupported,
                     file_.path() + " has more than " + std::to_string(kElementsMax) + " elements; record it again"};
      const std::uint64_t at = file_.at();
      const auto element = read_element(file_);
      if (!element) return cut(element.error());
      if (element->id == Id::cluster && head_.first_cluster_at == 0) head_.first_cluster_at = at;
      if (auto ok = take(*element); !ok) return cut(ok.error());
    }
    return std::move(head_);
  }

 private:
  // Damage among or behind the blocks is theirs to report.
  Result<MatroskaHead> cut(const Error& error) {
    if (error.code != ErrorCode::corrupt || head_.first_cluster_at == 0) return error;
    head_.whole = false;
    return std::move(head_);
  }

  Status take(const Element& element) {
    const Id id = element.id;
    if (!element.size && !may_have_no_size(id)) return damaged(file_, "an element without a size");
    const std::uint64_t size = element.size.value_or(0);
    switch (id) {
      case Id::segment:
      case Id::info:
      case Id::tracks:
      case Id::video:
      case Id::attachments:
      case Id::tags:
      case Id::targets:
        return Ok{};
      case Id::track_entry:
        return enter(head_.tracks);
      case Id::attached_file:
        return enter(head_.attachments);
      case Id::tag:
        tag_track_ = tag_attachment_ = 0;
        return Ok{};
      case Id::simple_tag:
        if (auto ok = enter(head_.tags); !ok) return ok;
        head_.tags.back().track_uid = tag_track_;
        head_.tags.back().attachment_uid = tag_attachment_;
        return Ok{};
      case Id::cluster:
        if (!element.size) return Ok{};
        break;
      default:
        if (const auto taken = take_value(id, size)) return *taken;
        break;
    }
    return pass(size);
  }

  template <class Entry>
  Status enter(std::vector<Entry>& entries) {
    if (entries.size() == kEntriesMax)
      return Error{ErrorCode::unsupported, file_.path() + " has more than " + std::to_string(kEntriesMax) +
                                               " tracks, tags or attachments; record it again"};
    entries.emplace_back();
    return Ok{};
  }

  Status pass(std::uint64_t size) {
    if (size > file_.left())
      return Error{ErrorCode::corrupt, file_.path() + " ends at byte " + std::to_string(file_.size()) +
                                           ", within an element; copy or record it again"};
    file_.seek(file_.at() + size);
    return Ok{};
  }

  Status number_to(std::uint64_t& out, std::uint64_t size) {
    const auto value = read_number(file_, size);
    if (!value) return value.error();
    out = *value;
    return Ok{};
  }
  Status text_to(std::string& out, std::uint64_t size) {
    auto value = read_text(file_, size);
    if (!value) return value.error();
    out = std::move(*value);
    return Ok{};
  }

  // None: the element is of no interest.
  std::optional<Status> take_value(Id id, std::uint64_t size) {
    if (id == Id::timestamp_scale) return number_to(head_.timestamp_scale_ns, size);
    if (id == Id::tag_track_uid) return number_to(tag_track_, size);
    if (id == Id::tag_attachment_uid) return number_to(tag_attachment_, size);
    if (id == Id::doc_type) return check_doc_type(size);
    if (!head_.tracks.empty())
      if (auto taken = take_of(head_.tracks.back(), id, size)) return taken;
    if (!head_.attachments.empty())
      if (auto taken = take_of(head_.attachments.back(), id, size)) return taken;
    if (head_.tags.empty()) return std::nullopt;
    if (id == Id::tag_name) return text_to(head_.tags.back().name, size);
    if (id == Id::tag_string) return text_to(head_.tags.back().value, size);
    return std::nullopt;
  }

  Status check_doc_type(std::uint64_t size) {
    const auto type = read_text(file_, size);
    if (!type) return type.error();
    if (*type == "matroska" || *type == "webm") return Ok{};
    return Error{ErrorCode::unsupported,
                 file_.path() + " is a file of the kind " + excerpt(*type) + ", expected matroska"};
  }

  std::optional<Status> take_of(MatroskaTrack& track, Id id, std::uint64_t size) {
    switch (id) {
      case Id::track_number:
        return number_to(track.number, size);
      case Id::track_uid:
        return number_to(track.uid, size);
      case Id::track_type:
        return number_to(track.type, size);
      case Id::track_name:
        return text_to(track.name, size);
      case Id::codec_id:
        return text_to(track.codec, size);
      case Id::pixel_width:
        return number_to(track.width, size);
      case Id::pixel_height:
        return number_to(track.height, size);
      case Id::codec_private:
      case Id::colour_space: {
        if (size > kTextMax) return pass(size);  // a video's headers
        auto bytes = read_bytes(file_, size, kTextMax);
        if (!bytes) return Status(bytes.error());
        (id == Id::codec_private ? track.codec_private : track.colour_space) = std::move(*bytes);
        return Status(Ok{});
      }
      case Id::content_encodings:
        track.encoded = true;
        return pass(size);
      default:
        return std::nullopt;
    }
  }

  std::optional<Status> take_of(MatroskaAttachment& attachment, Id id, std::uint64_t size) {
    switch (id) {
      case Id::file_name:
        return text_to(attachment.name, size);
      case Id::file_uid:
        return number_to(attachment.uid, size);
      case Id::file_data:
        attachment.at = file_.at();
        attachment.size = size;
        return pass(size);
      default:
        return std::nullopt;
    }
  }

  FileCursor& file_;
  MatroskaHead head_;
  std::uint64_t tag_track_ = 0, tag_attachment_ = 0;
};

}  // namespace

Result<MatroskaHead> read_matroska_head(FileCursor& file) {
  return HeadReader(file).read();
}

Result<std::string> read_matroska_attachment(FileCursor& file, const MatroskaAttachment& attachment) {
  file.seek(attachment.at);
  return read_bytes(file, attachment.size, kTextBytesMax);
}

void MatroskaBlocks::restart(std::uint64_t at) {
  next_at_ = at;
  cluster_time_ = 0;
}

Result<std::optional<MatroskaBlock>> MatroskaBlocks::next() {
  file_.seek(next_at_);
  const auto failed = [&](Error error) {
    next_at_ = file_.size();
    return error;
  };
  while (file_.left() > 0) {
    const auto element = read_element(file_);
    if (!element) return failed(element.error());
    const bool enters = element->id == Id::segment || element->id == Id::cluster || element->id == Id::block_group;
    if (enters) continue;
    if (!element->size) return failed(damaged(file_, "an element without a size"));
    if (*element->size > file_.left())
      return failed({ErrorCode::corrupt, file_.path() + " ends at byte " + std::to_string(file_.size()) +
                                             ", within an element; it was cut off, or its recorder was"});
    const std::uint64_t end = file_.at() + *element->size;
    if (element->id == Id::timestamp) {
      const auto time = read_number(file_, *element->size);
      if (!time) return failed(time.error());
      if (*time > kTimeMax) return failed(damaged(file_, "an impossible time"));
      cluster_time_ = *time;
    } else if (element->id == Id::simple_block || element->id == Id::block) {
      auto found = block(end);
      if (!found) return failed(found.error());
      next_at_ = end;
      if (*found) return found;
    }
    file_.seek(end);
  }
  next_at_ = file_.size();
  return std::optional<MatroskaBlock>();
}

// None: of another track. Its bytes begin with the track, the time after the cluster's and flags.
Result<std::optional<MatroskaBlock>> MatroskaBlocks::block(std::uint64_t end) {
  const auto track = read_varint(file_, 8, false);
  if (!track) return track.error();
  if (track->value != track_) return std::optional<MatroskaBlock>();
  std::array<std::byte, 3> about{};
  if (auto ok = file_.read(about); !ok) return ok.error();
  if (file_.at() > end) return damaged(file_, "a block without a time");
  const auto after =
      static_cast<std::int16_t>(std::to_integer<unsigned>(about[0]) << 8 | std::to_integer<unsigned>(about[1]));
  constexpr std::byte kLacing{0x06};
  return std::optional(MatroskaBlock{static_cast<std::int64_t>(cluster_time_) + after, end - file_.at(),
                                     (about[2] & kLacing) != std::byte{0}});
}

}  // namespace im2fit::hal
