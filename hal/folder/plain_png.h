// SPDX-License-Identifier: Apache-2.0
// 16-bit grey PNGs as cameras' programs write them, decoded at once instead of row by row: half of libpng's work.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/camera.h"

namespace im2fit::hal {

// False, and `out` undefined, for whatever is not a whole, undamaged, not interlaced 16-bit grey PNG of the size of
// `out`: libpng then decides, and says what is wrong. Pixels in the file's byte order (most significant byte first).
// `rows`: memory for the work, kept from picture to picture.
bool decode_plain_png(std::span<const std::byte> bytes, std::vector<std::uint8_t>& rows, DepthImage out);

}  // namespace im2fit::hal
