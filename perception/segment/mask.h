// SPDX-License-Identifier: Apache-2.0
// From chosen cells to the full-resolution mask.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/segment/grid.h"
#include "perception/segment/segment.h"

namespace im2fit::segment {

class MaskRefiner {
 public:
  explicit MaskRefiner(const Grid& grid);
  // Sets `mask` to 255 where a pixel belongs to the cells with `chosen` != 0 (which have depth), else 0.
  void run(const Grid& grid, DepthView depth, std::span<const std::uint8_t> chosen, MaskImage mask);

 private:
  void fill_planes(const Grid& grid, std::span<const std::uint8_t> chosen);
  int list_cells(const Grid& grid, std::span<const std::uint8_t> chosen);

  int stride_;                                 // of the planes, which have a cell more on every side
  std::vector<std::uint16_t> person_, other_;  // depths, kNoSurface elsewhere
  std::vector<std::uint8_t> row_any_;          // of a row's cells: one of the person's is it or touches it
  std::vector<std::uint32_t> list_;
};

// Box, count, centroid and touched borders of the mask.
void describe_mask(const Grid& grid, DepthView depth, MaskView mask, Person& person);

}  // namespace im2fit::segment
