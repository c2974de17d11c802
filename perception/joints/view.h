// SPDX-License-Identifier: Apache-2.0
// The masked depth the joint model reads: the person's box, downsampled to a focal length of about 288 px, so that
// one model serves 640x480, 320x240, landscape and portrait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "perception/segment/segment.h"

namespace im2fit::joints {

inline constexpr float kViewFocalPx = 288.0F;
inline constexpr std::size_t kViewPixelCountMax = 512U * 512U;

struct View {
  int u_first = 0, v_first = 0;  // of the box, downsampled px
  int width = 0, height = 0;
  float fx = 1, fy = 1, cx = 0, cy = 0;  // of the downsampled picture
  Vec3f centroid_mm;
  int pixel_count = 0;
  std::vector<std::uint16_t> depth;  // mm, 0 outside the mask

  // Of the box. The offset keeps the truncation a floor for rays left of and above the picture.
  int column_of(float rx) const { return static_cast<int>(fx * rx + cx + 8192.5F) - 8192 - u_first; }
  int row_of(float ry) const { return static_cast<int>(fy * ry + cy + 8192.5F) - 8192 - v_first; }
  // nullptr: beside the box.
  const std::uint16_t* pixel_at_ray(float rx, float ry) const {
    const int u = column_of(rx);
    const int v = row_of(ry);
    if (static_cast<unsigned>(u) >= static_cast<unsigned>(width) ||
        static_cast<unsigned>(v) >= static_cast<unsigned>(height))
      return nullptr;
    return depth.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
  }
  int at_ray(float rx, float ry) const {
    const std::uint16_t* pixel = pixel_at_ray(rx, ry);
    return pixel != nullptr ? *pixel : 0;
  }
};

// The same as a mirror shows it; `out.depth` as in downsample().
void mirror(const View& view, View& out);

// Fills `view`, whose `depth` must have kViewPixelCountMax places (or enough for the box): no allocation then.
// Returns false when the mask is empty.
bool downsample(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Person& person, View& view);

}  // namespace im2fit::joints
