// SPDX-License-Identifier: Apache-2.0
// Learning the jump forest: per joint, trees that probe about a point and estimate how far the joint is.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "perception/joints/model_data.h"
#include "train/tracker/tracker_images.h"
#include "train/tracker/train_tracker.h"

namespace im2fit::lab {

// A forest that owns its arrays.
struct Forest {
  std::uint32_t tree_count = 0;
  std::uint32_t jump_count = 0;
  std::vector<std::uint32_t> tree_start;
  std::vector<joints::JumpNode> nodes;
  std::vector<std::int16_t> bone;
  joints::ForestView view() const { return {tree_count, jump_count, tree_start, nodes, bone}; }
};

// Tree t learns on the images i with i % 2 == t % 2: view().half(h) never saw those with i % 2 != h.
Forest train_forest(std::span<const TrackerImage> images, const TrainOptions& options,
                    const std::function<void(double)>& progress);

}  // namespace im2fit::lab
