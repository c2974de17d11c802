// SPDX-License-Identifier: Apache-2.0
// A room with a floor, a wall and one person of a head, a trunk and two legs, as a noisy sensor sees it: what the
// kernels of one frame are measured on.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/rng.h"

namespace im2fit::bench {

struct RoomPicture {
  int width = 0, height = 0;
  Intrinsics intrinsics;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;  // the person's pixels
  DepthView view() const { return {depth.data(), width, height}; }
  MaskView mask_view() const { return {mask.data(), width, height}; }
};

// The person stands 2.4 m away and covers a tenth of the picture; one pixel in fifty has no data.
inline std::shared_ptr<const RoomPicture> room_picture(int width, int height) {
  auto out = std::make_shared<RoomPicture>();
  const float focal = 575.8F * static_cast<float>(width > height ? width : height) / 640;
  out->width = width;
  out->height = height;
  out->intrinsics = {
      width, height, focal, focal, 0.5F * static_cast<float>(width - 1), 0.5F * static_cast<float>(height - 1)};
  const Intrinsics& k = out->intrinsics;
  Rng rng(3);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const float rx = (static_cast<float>(u) - k.cx) / k.fx, ry = (static_cast<float>(v) - k.cy) / k.fy;
      float z = 3500;
      if (ry > 0 && 1000 / ry < z) z = 1000 / ry;  // the camera is 1 m above the floor
      const float x = rx * 2400, y = ry * 2400;    // on the person's plane
      const auto bar = [&](float centre, float half, float top, float bottom) {
        const float off = x > centre ? x - centre : centre - x;
        if (off < half && y > top && y < bottom) z = 2400 + 100 * off / half * off / half;
        return off < half && y > top && y < bottom;
      };
      const bool person = bar(0, 80, -760, -540) || bar(0, 190, -540, 60) || bar(-100, 80, 60, 980) ||
                          bar(100, 80, 60, 980) || bar(-300, 45, -450, 150) || bar(300, 45, -450, 150);
      z += z * z * 2.85e-6F * 0.5F * rng.fast_normal();
      const bool lost = rng.index(50) == 0;
      out->depth.push_back(lost ? std::uint16_t{0} : static_cast<std::uint16_t>(z));
      out->mask.push_back(person && !lost ? 255 : 0);
    }
  }
  return out;
}

}  // namespace im2fit::bench
