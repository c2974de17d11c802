// SPDX-License-Identifier: Apache-2.0
// A driver that smooths depth over time, an option of many drivers.
#pragma once

#include <cstddef>
#include <vector>

#include "core/camera.h"

namespace im2fit::lab {

// Exponential smoothing, pixel by pixel: each frame moves the delivered depth by kShare of the difference, and a step
// beyond kOutlierMm, another surface, all of it. Pixels without data stay without, and begin anew.
class TemporalSmoothing {
 public:
  static constexpr float kShare = 0.25F;
  // In place; frames of one size.
  void run(DepthImage frame);

 private:
  std::vector<float> smooth_mm_;
};

}  // namespace im2fit::lab
