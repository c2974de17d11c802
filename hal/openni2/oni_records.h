// SPDX-License-Identifier: Apache-2.0
// The bytes of a .oni file with one depth stream, as OpenNI2 2.2 writes them: a file header, then records. Each
// record begins with {u32 magic, type, node, size of header and fields, size of payload; u64 position of the record
// that seeking backwards undoes to}. All little-endian and without padding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/intrinsics.h"

namespace im2fit::hal::oni {

using Bytes = std::vector<std::byte>;

// The runtime reads a frame or a seek table into a buffer, and decodes a frame into another, of 1600 x 1200 x 3
// bytes.
inline constexpr std::size_t kPayloadBytesMax = 5'760'000;

// What stands before the first frame. Its size does not depend on the numbers that are known only at the end, so that
// it can be written again in place.
struct Head {
  int width = 0;
  int height = 0;
  int fps = 30;
  FieldOfView view;
  std::string camera_name;
  // As OpenNI2's recorder leaves them when it is killed; the runtime then plays to the last frame it finds.
  std::uint32_t frame_number_max = 0xFFFFFFFF;
  std::uint64_t time_min_us = 0;
  std::uint64_t time_max_us = ~std::uint64_t{0};
  std::uint64_t seek_table_at = 0;  // 0: there is none
};
Bytes head(const Head& about);

// Where a frame's record begins. Frames are numbered from 1; numbers may be missing.
struct FrameEntry {
  std::uint32_t number = 0;
  std::uint64_t time_us = 0;
  std::uint64_t at = 0;
};
// The record but for its payload, which finish_frame() counts once it was appended. `before_at`: the record of the
// frame before, 0 for none.
void begin_frame(Bytes& out, const FrameEntry& frame, std::uint64_t before_at);
void finish_frame(Bytes& out);

// What stands behind the last frame, which ends at `at`: the node is removed, the seek table, the end. A missing
// number seeks to the frame before it. A table too long for the runtime is left out: it then seeks from frame to
// frame.
struct Tail {
  Bytes bytes;
  std::uint64_t seek_table_at = 0;
};
Tail tail(std::span<const FrameEntry> frames, std::uint64_t at);

}  // namespace im2fit::hal::oni
