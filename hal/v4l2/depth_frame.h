// SPDX-License-Identifier: Apache-2.0
// Where the depth lies in a V4L2 buffer, and its conversion to millimetres.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/camera.h"

namespace im2fit::hal {

struct DepthLayout {
  int width = 0;
  int height = 0;
  std::size_t offset_bytes = 0;  // of the first depth row
  std::size_t stride_bytes = 0;  // from row to row, at least 2 * width
  int unit_um = 1000;            // of one step of the 16-bit values, 1..100'000

  // Up to the last pixel: drivers may leave out the padding behind it.
  std::size_t size_bytes() const;
};

// Fills `out`, rounded to mm, 0.5 up; depths beyond 65,535 mm become 0, no data. False, with `out` untouched,
// when `buffer` is too short or `out` has another size. The values are little-endian, as Z16 and Y16 are.
bool copy_depth(std::span<const std::byte> buffer, const DepthLayout& layout, DepthImage out);

}  // namespace im2fit::hal
