// SPDX-License-Identifier: Apache-2.0
// Learning the cascade: levels of boosted depth-5 trees on shape-indexed depth differences (Kazemi 2014).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "perception/joints/model_data.h"
#include "train/tracker/tracker_images.h"
#include "train/tracker/train_tracker.h"

namespace im2fit::lab {

struct CascadeStart {
  std::int32_t image = 0;
  joints::Shape shape{};
};

struct Cascade {
  std::vector<joints::Anchor> anchors;
  std::vector<joints::Split> splits;
  std::vector<std::int8_t> leaves;
  std::vector<joints::Basis> basis;  // by level
};

// `starts` are moved to where the cascade takes them.
Cascade train_cascade(std::span<const TrackerImage> images, std::vector<CascadeStart>& starts,
                      const TrainOptions& options, const std::function<void(double)>& progress);

}  // namespace im2fit::lab
