// SPDX-License-Identifier: Apache-2.0
// One view's joints: the middle of what several runs of the model say.
#pragma once

#include <array>

#include "perception/joints/model_data.h"

namespace im2fit::joints {

struct Estimate {
  Shape shape{};
  std::array<float, kJointCount> spread_mm{};  // rises with the error to be expected
};

// What the mirror image says, said of the view itself, and back.
Estimate mirrored(const Estimate& estimate);

// Six runs: started by all trees and by either half of them, on the view and on its mirror image. Their errors are
// not the same, so the median coordinate is better than any of them (as Cao et al. 2012, section 4, from several
// starts). `mirror_image`: mirror(view).
Estimate estimate(const JointModel::Data& model, const View& view, const View& mirror_image);

}  // namespace im2fit::joints
