// SPDX-License-Identifier: Apache-2.0
// Learning front from back by depths about the joints.
#pragma once

#include <cstdint>
#include <span>

#include "perception/joints/model_data.h"
#include "train/tracker/tracker_images.h"
#include "train/tracker/tracker_votes.h"
#include "train/tracker/train_tracker.h"

namespace im2fit::lab {

struct SideExample {
  std::int32_t image = 0;
  joints::Shape shape{};  // as the cascade leaves it
};

// No trees when the images show one side only.
VoteTrees train_side(std::span<const TrackerImage> images, std::span<const SideExample> examples,
                     const TrainOptions& options);

}  // namespace im2fit::lab
