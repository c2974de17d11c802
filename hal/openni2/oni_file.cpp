// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/oni_file.h"

#include <cstring>
#include <span>

#include "base/file.h"

namespace im2fit::hal {
namespace {

// As OpenNI2 2.2 writes them, packed, little-endian: a file header of 24 bytes beginning "NI10"; then records, each a
// header of seven words {magic, type, node, size of header and fields, size of payload, u64 undo position}.
constexpr std::size_t kFileHeaderBytes = 24;
constexpr std::size_t kRecordHeaderBytes = 28;
constexpr std::uint32_t kRecordMagic = 0x0052494E;  // "NIR\0"
constexpr std::uint32_t kNewData = 0x0A;
constexpr std::uint32_t kEnd = 0x0B;

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

}  // namespace

Result<OniContents> inspect_oni(const std::string& path) {
  const auto file = MappedFile::open(path);
  if (!file) return file.error();
  const auto bytes = file->bytes();
  if (bytes.size() < kFileHeaderBytes || std::memcmp(bytes.data(), "NI10", 4) != 0)
    return Error{ErrorCode::corrupt, path + " does not begin as an OpenNI recording does"};
  OniContents contents;
  for (std::size_t at = kFileHeaderBytes; at < bytes.size();) {
    const std::size_t left = bytes.size() - at;
    const std::size_t size = left < kRecordHeaderBytes ? 0
                                                       : static_cast<std::size_t>(word(bytes, at + 12)) +
                                                             static_cast<std::size_t>(word(bytes, at + 16));
    if (size < kRecordHeaderBytes || size > left || word(bytes, at) != kRecordMagic)
      return Error{ErrorCode::corrupt, path + " breaks off or is damaged at byte " + std::to_string(at) + ", after " +
                                           std::to_string(contents.frames) + " frames"};
    const std::uint32_t type = word(bytes, at + 4);
    if (type == kNewData) ++contents.frames;
    at += size;
    contents.size_bytes = at;
    if (type == kEnd) {
      contents.closed = true;
      break;
    }
  }
  return contents;
}

}  // namespace im2fit::hal
