// SPDX-License-Identifier: Apache-2.0
#include "hal/v4l2/depth_frame.h"

#include <bit>
#include <cstring>

namespace im2fit::hal {

static_assert(std::endian::native == std::endian::little, "Z16 and Y16 are copied as they are");

std::size_t DepthLayout::size_bytes() const {
  if (width < 1 || height < 1) return 0;
  return offset_bytes + stride_bytes * static_cast<std::size_t>(height - 1) + static_cast<std::size_t>(width) * 2;
}

bool copy_depth(std::span<const std::byte> buffer, const DepthLayout& layout, DepthImage out) {
  if (layout.width < 1 || layout.height < 1 || layout.width != out.width || layout.height != out.height) return false;
  const std::size_t row_bytes = static_cast<std::size_t>(layout.width) * 2;
  if (layout.stride_bytes < row_bytes || layout.unit_um < 1 || buffer.size() < layout.size_bytes()) return false;
  const std::byte* from = buffer.data() + layout.offset_bytes;
  const auto unit_um = static_cast<std::uint64_t>(layout.unit_um);
  for (int v = 0; v < out.height; ++v, from += layout.stride_bytes) {
    std::uint16_t* row = out.row(v);
    std::memcpy(row, from, row_bytes);
    if (unit_um == 1000) continue;
    for (int u = 0; u < out.width; ++u) {
      const std::uint64_t mm = (row[u] * unit_um + 500) / 1000;
      row[u] = mm <= 65535 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
    }
  }
  return true;
}

}  // namespace im2fit::hal
