// SPDX-License-Identifier: Apache-2.0
// What the camera sees, as small as a page needs it: grey, the person brighter than everything else.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/camera.h"
#include "core/status.h"

namespace im2fit::apps {

inline constexpr int kSmallPictureSidePx = 160;  // the longer side, or less

// A PNG of one byte a pixel: some 5 kB, 20 kB at most whatever the camera sees. `depth` in mm, upright, of any size;
// `mask` empty or of the same size, other than 0 where the person is.
Result<std::string> small_picture(DepthView depth, MaskView mask);
// A PNG of these grey values, row by row.
Result<std::string> grey_png(std::span<const std::uint8_t> pixels, int width, int height);

}  // namespace im2fit::apps
