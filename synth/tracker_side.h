// SPDX-License-Identifier: Apache-2.0
// Learning front from back: boosted trees with logistic loss (Friedman 2001) on shape-indexed depth differences.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/joints/model_data.h"
#include "synth/tracker_images.h"
#include "synth/train_tracker.h"

namespace im2fit::synth {

struct SideTrees {
  std::vector<joints::Anchor> anchors;
  std::vector<joints::Split> splits;
  std::vector<std::int16_t> leaves;
  std::size_t tree_count() const { return splits.size() / static_cast<std::size_t>(joints::kSplitCount); }
};

struct SideExample {
  std::int32_t image = 0;
  joints::Shape shape{};  // as the cascade leaves it
};

// No trees when the images show one side only.
SideTrees train_side(std::span<const TrackerImage> images, std::span<const SideExample> examples,
                     const TrainOptions& options);

}  // namespace im2fit::synth
