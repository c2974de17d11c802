// SPDX-License-Identifier: Apache-2.0
// A driver that smooths depth over time, as many do when they are asked to.
#pragma once

#include <cstddef>
#include <vector>

#include "core/camera.h"

namespace im2fit::lab {

// Exponential smoothing, pixel by pixel: each frame moves what is delivered by kShare of the way, and a step beyond
// kOutlierMm, another surface, all of it. Pixels without data stay without, and begin anew.
class TemporalSmoothing {
 public:
  static constexpr float kShare = 0.25F;
  // In place; frames of one size.
  void run(DepthImage frame);

 private:
  std::vector<float> smooth_mm_;
};

}  // namespace im2fit::lab
