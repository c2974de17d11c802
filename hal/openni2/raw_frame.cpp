// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/raw_frame.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace im2fit::hal {
namespace {

bool fits(const RawFrame& frame, const DepthImage& out) {
  if (frame.data == nullptr || frame.width < 1 || frame.height < 1 || frame.width > kImageSideMax ||
      frame.height > kImageSideMax || frame.crop_x < 0 || frame.crop_y < 0 || frame.crop_x > kImageSideMax ||
      frame.crop_y > kImageSideMax || (frame.unit_um != 1000 && frame.unit_um != 100))
    return false;
  if (frame.crop_x + frame.width > out.width || frame.crop_y + frame.height > out.height) return false;
  const int row_bytes = frame.width * 2;
  if (frame.stride_bytes < row_bytes || frame.stride_bytes % 2 != 0 || frame.stride_bytes > 4 * kImageSideMax)
    return false;
  const auto needed = static_cast<std::size_t>(frame.stride_bytes) * static_cast<std::size_t>(frame.height - 1) +
                      static_cast<std::size_t>(row_bytes);
  return frame.size_bytes >= needed;
}

}  // namespace

bool copy_raw_frame(const RawFrame& frame, DepthImage out) {
  if (!fits(frame, out)) return false;
  if (frame.width != out.width || frame.height != out.height) {
    for (int v = 0; v < out.height; ++v) std::fill_n(out.row(v), out.width, std::uint16_t{0});
  }
  const auto* bytes = static_cast<const unsigned char*>(frame.data);
  for (int v = 0; v < frame.height; ++v) {
    std::uint16_t* row = out.row(frame.crop_y + v) + frame.crop_x;
    std::memcpy(row, bytes + static_cast<std::size_t>(v) * static_cast<std::size_t>(frame.stride_bytes),
                static_cast<std::size_t>(frame.width) * 2);
    if (frame.unit_um == 100) {
      for (int u = 0; u < frame.width; ++u) row[u] = static_cast<std::uint16_t>((row[u] + 5) / 10);
    }
    if (frame.mirrored) std::reverse(out.row(frame.crop_y + v), out.row(frame.crop_y + v) + out.width);
  }
  return true;
}

}  // namespace im2fit::hal
