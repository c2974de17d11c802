// SPDX-License-Identifier: Apache-2.0
// What im2fit-oni-reader writes into its pipe: messages of a header and a payload, in the machine's own byte order,
// since both ends are one build on one machine. Hello, frames, then end or failure.
#pragma once

#include <cstdint>
#include <type_traits>

namespace im2fit::hal::oni {

inline constexpr std::uint32_t kMagic = 0x524F3249;  // "I2OR"

enum class Kind : std::uint32_t { hello = 1, frame = 2, end = 3, failure = 4 };

struct Header {
  std::uint32_t magic = kMagic;
  Kind kind = Kind::hello;
  std::uint32_t payload_bytes = 0;
  std::uint32_t reserved = 0;
};

struct Hello {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::int32_t fps = 0;
  std::int32_t frame_count = 0;  // the largest frame number; -1: the file was never closed
  float horizontal_rad = 0;
  float vertical_rad = 0;
};

struct Frame {  // followed by width x height depths in mm
  std::uint64_t index = 0;
  std::uint64_t timestamp_us = 0;
};

struct End {
  std::uint32_t complete = 0;  // 0: frames ran out before the number the file states, or it states none
};

inline constexpr std::uint32_t kFailureBytesMax = 1024;  // one line of text

static_assert(sizeof(Header) == 16 && sizeof(Hello) == 24 && sizeof(Frame) == 16);
static_assert(std::is_trivially_copyable_v<Header>);

}  // namespace im2fit::hal::oni
