// SPDX-License-Identifier: Apache-2.0
// One view's joints: the median of several runs of the model.
#pragma once

#include <array>

#include "perception/joints/model_data.h"

namespace im2fit::joints {

struct JointEstimate {
  Shape shape{};
  std::array<float, kJointCount> spread_mm{};  // rises with the error to be expected
};

// The estimate of the mirror image in coordinates of the view itself, and back.
JointEstimate mirrored(const JointEstimate& estimate);

// Six runs: started by all trees and by either half of them, on the view and on its mirror image. Their errors are
// not the same, so the median coordinate is better than any of them (as Cao et al. 2012, section 4, from several
// starts). `mirror_image`: mirror(view).
JointEstimate estimate(const JointModel::Data& model, const View& view, const View& mirror_image);

}  // namespace im2fit::joints
