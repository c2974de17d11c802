// SPDX-License-Identifier: Apache-2.0
// The jump forest, several runs side by side. A walk down a tree is a chain of loads that miss the caches; those of
// all runs and trees are independent, so that their misses overlap.
#pragma once

#include <cstddef>
#include <span>

#include "perception/joints/model_data.h"

namespace im2fit::joints {

inline constexpr std::size_t kForestRunsMax = 6;
struct ForestRun {
  ForestView forest;
  const View* view = nullptr;
  Shape shape{};  // the answer
};
// kForestRunsMax at most, all of one model: forests differ in their trees alone. Each run's answer is the one it has
// alone. No allocation.
void run_forests(std::span<ForestRun> runs);

}  // namespace im2fit::joints
