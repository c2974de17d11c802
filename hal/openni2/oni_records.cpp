// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/oni_records.h"

#include <bit>
#include <initializer_list>

namespace im2fit::hal::oni {
namespace {

constexpr std::uint32_t kRecordMagic = 0x0052494E;  // "NIR\0"
constexpr std::size_t kRecordHeaderBytes = 28;
constexpr std::size_t kSeekEntryBytes = 20;
constexpr std::uint64_t kFileHeaderBytes = 24;  // the node's first record follows it
constexpr std::uint32_t kNode = 1;

enum class Type : std::uint32_t {
  int_property = 0x03,
  string_property = 0x05,
  general_property = 0x06,
  node_removed = 0x07,
  data_begin = 0x08,
  state_ready = 0x09,
  new_data = 0x0A,
  end = 0x0B,
  node_added = 0x0D,
  seek_table = 0x0E,
};

template <class T>
void store(std::byte* to, T value) {
  for (std::size_t i = 0; i < sizeof value; ++i) to[i] = static_cast<std::byte>((value >> (8 * i)) & 0xFF);
}
void put32(Bytes& out, std::uint32_t value) {
  out.resize(out.size() + sizeof value);
  store(&out[out.size() - sizeof value], value);
}
void put64(Bytes& out, std::uint64_t value) {
  out.resize(out.size() + sizeof value);
  store(&out[out.size() - sizeof value], value);
}
void put_string(Bytes& out, const std::string& text) {
  put32(out, static_cast<std::uint32_t>(text.size() + 1));
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
  out.push_back(std::byte{0});
}

// A record that is being appended; the size of its fields is known once they are there.
class Record {
 public:
  Record(Bytes& out, Type type, std::uint64_t undo_at = 0, std::uint32_t node = kNode) : out_(out), at_(out.size()) {
    put32(out, kRecordMagic);
    put32(out, static_cast<std::uint32_t>(type));
    put32(out, node);
    put32(out, 0);
    put32(out, 0);
    put64(out, undo_at);
  }
  void end_fields() { store(&out_[at_ + 12], static_cast<std::uint32_t>(out_.size() - at_)); }

 private:
  Bytes& out_;
  std::size_t at_;
};

void property(Bytes& out, const std::string& name, std::uint64_t value) {
  Record record(out, Type::int_property);
  put_string(out, name);
  put32(out, sizeof value);
  put64(out, value);
  record.end_fields();
}

void property(Bytes& out, const std::string& name, std::initializer_list<std::uint32_t> words) {
  Record record(out, Type::general_property);
  put_string(out, name);
  put32(out, static_cast<std::uint32_t>(words.size() * sizeof(std::uint32_t)));
  for (const std::uint32_t word : words) put32(out, word);
  record.end_fields();
}

void property(Bytes& out, const std::string& name, const FieldOfView& view) {
  Record record(out, Type::general_property);
  put_string(out, name);
  put32(out, 2 * sizeof(double));
  put64(out, std::bit_cast<std::uint64_t>(static_cast<double>(view.horizontal_rad)));
  put64(out, std::bit_cast<std::uint64_t>(static_cast<double>(view.vertical_rad)));
  record.end_fields();
}

void property(Bytes& out, const std::string& name, const std::string& text) {
  Record record(out, Type::string_property);
  put_string(out, name);
  put_string(out, text);
  record.end_fields();
}

void plain_record(Bytes& out, Type type, std::uint64_t undo_at = 0, std::uint32_t node = kNode) {
  Record(out, type, undo_at, node).end_fields();
}

void file_header(Bytes& out, const Head& about) {
  for (const char c : {'N', 'I', '1', '0'}) out.push_back(static_cast<std::byte>(c));
  put32(out, 0x00010001);  // version 1.0.1.0: two bytes, a u16
  put32(out, 0);           // and a u32
  put64(out, about.time_max_us);
  put32(out, kNode);  // the largest node
}

void node_added(Bytes& out, const Head& about) {
  constexpr std::uint32_t kDepth = 2;
  Record record(out, Type::node_added);
  put_string(out, "Depth");
  put32(out, kDepth);
  for (const char c : {'1', '6', 'z', 'T'}) out.push_back(static_cast<std::byte>(c));
  put32(out, about.frame_number_max);
  put64(out, about.time_min_us);
  put64(out, about.time_max_us);
  put64(out, about.seek_table_at);
  record.end_fields();
}

}  // namespace

Bytes head(const Head& about) {
  constexpr std::uint64_t kGrey16 = 4;      // XnPixelFormat, of OpenNI 1
  constexpr std::uint64_t kDepth_mm = 100;  // ONI_PIXEL_FORMAT_DEPTH_1_MM
  const auto width = static_cast<std::uint32_t>(about.width);
  const auto height = static_cast<std::uint32_t>(about.height);
  const auto fps = static_cast<std::uint32_t>(about.fps);
  Bytes out;
  file_header(out, about);
  node_added(out, about);
  property(out, "oniRequiredFrameSize", std::uint64_t{2} * width * height);
  property(out, "xnIsGenerating", 1);
  property(out, "xnDeviceMaxDepth", 65535);
  property(out, "xnSupportedMapOutputModesCount", 1);
  property(out, "xnSupportedMapOutputModes", {width, height, fps});
  property(out, "xnMapOutputMode", {width, height, fps});
  property(out, "xnSupportedPixelFormats", {1U << (kGrey16 - 1)});
  property(out, "xnPixelFormat", kGrey16);
  property(out, "oniPixelFormat", kDepth_mm);
  property(out, "xnFOV", about.view);
  // Without these the runtime plays no frame and gives no error.
  property(out, "Cropping", 1);
  property(out, "xnCropping", {0, 0, 0});
  property(out, "Mirror", 1);
  property(out, "xnMirror", 0);
  property(out, "im2fitCameraName", about.camera_name);  // OpenNI2 has no place for it and passes over this one
  plain_record(out, Type::state_ready);
  Record data_begin(out, Type::data_begin);
  put32(out, 0xFFFFFFFF);  // as the node's record was written at first, for readers of version 1.0.0.4
  put64(out, ~std::uint64_t{0});
  data_begin.end_fields();
  return out;
}

void begin_frame(Bytes& out, const FrameEntry& frame, std::uint64_t before_at) {
  out.clear();
  Record record(out, Type::new_data, before_at);
  put64(out, frame.time_us);
  put32(out, frame.number);
  record.end_fields();
}

void finish_frame(Bytes& out) {
  constexpr std::size_t kFieldsEnd = kRecordHeaderBytes + 12;
  store(&out[16], static_cast<std::uint32_t>(out.size() - kFieldsEnd));
}

Tail tail(std::span<const FrameEntry> frames, std::uint64_t at) {
  Tail tail;
  plain_record(tail.bytes, Type::node_removed, kFileHeaderBytes);
  const std::size_t table_bytes = (std::size_t{frames.back().number} + 1) * kSeekEntryBytes;
  if (table_bytes <= kPayloadBytesMax) {
    tail.seek_table_at = at + tail.bytes.size();
    const std::size_t begin = tail.bytes.size();
    tail.bytes.reserve(begin + kRecordHeaderBytes + table_bytes + kRecordHeaderBytes);
    plain_record(tail.bytes, Type::seek_table);
    store(&tail.bytes[begin + 16], static_cast<std::uint32_t>(table_bytes));
    const auto put_entry = [&](std::uint64_t time_us, std::uint64_t frame_at) {
      put64(tail.bytes, time_us);
      put32(tail.bytes, 0);  // the configuration, which never changes
      put64(tail.bytes, frame_at);
    };
    put_entry(0, 0);  // frames count from 1
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const std::uint32_t next = i + 1 < frames.size() ? frames[i + 1].number : frames[i].number + 1;
      for (std::uint32_t number = frames[i].number; number < next; ++number)
        put_entry(frames[i].time_us, frames[i].at);
    }
  }
  plain_record(tail.bytes, Type::end, 0, 0);
  return tail;
}

}  // namespace im2fit::hal::oni
