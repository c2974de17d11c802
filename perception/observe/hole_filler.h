// SPDX-License-Identifier: Apache-2.0
// Pictures that sunlight riddles with holes, filled so that the person in them is still found: a person full of holes
// is still a person. What is filled is for finding people only; it is never measured.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/lazy_zeros.h"

namespace im2fit {

// No allocation after construction; not shareable between threads; integers only.
class HoleFiller {
 public:
  HoleFiller(int width, int height);
  // `depth` itself, of the constructor's size, while less than a sixth of it is riddled; else a copy of it, valid
  // until the next run, in which a hole with data within a fortieth of the picture's long side in three directions at
  // least (left, right, above, below) has the lower median of these data. Shadows beside people and surfaces out of
  // range stay empty: they have data on two sides at most, or none near.
  DepthView run(DepthView depth);
  // Whether the last run's answer is a copy.
  bool filled() const { return filled_; }

 private:
  bool riddled(DepthView depth) const;
  void fill(DepthView depth);

  int reach_px_;
  bool filled_ = false;
  LazyZeros<std::uint16_t> out_;
  std::vector<int> above_row_, below_row_;  // by column: the nearest rows with data
};

// Share of the mask's pixels that have no data in `depth`, 0..1 (0 for an empty mask); these leave the mask.
float drop_lost_pixels(DepthView depth, MaskImage mask);

}  // namespace im2fit
