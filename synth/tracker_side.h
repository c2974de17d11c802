// SPDX-License-Identifier: Apache-2.0
// Learning front from back by depths about the joints.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/joints/model_data.h"
#include "synth/tracker_images.h"
#include "synth/tracker_votes.h"
#include "synth/train_tracker.h"

namespace im2fit::synth {

struct SideExample {
  std::int32_t image = 0;
  joints::Shape shape{};  // as the cascade leaves it
};

// No trees when the images show one side only.
VoteTrees train_side(std::span<const TrackerImage> images, std::span<const SideExample> examples,
                     const TrainOptions& options);

}  // namespace im2fit::synth
