// SPDX-License-Identifier: Apache-2.0
// The feet grown back into the floor band. Floor height carries stature.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/segment/grid.h"

namespace im2fit::segment {

class FootGrower {
 public:
  explicit FootGrower(int image_width) : lowest_(static_cast<std::size_t>(image_width)) {}
  // Adds shoe and foot pixels between the mask's lower end and the floor, none of cells with `barred` != 0. `mask` is
  // MaskRefiner's result for `chosen`.
  void run(const Grid& grid, DepthView depth, const FloorPlane& floor, std::span<const std::uint8_t> chosen,
           std::span<const std::uint8_t> barred, MaskImage mask);

 private:
  std::vector<std::int16_t> lowest_;  // per column: the mask's last row
};

}  // namespace im2fit::segment
