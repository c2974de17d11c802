// SPDX-License-Identifier: Apache-2.0
// Trains the joint model (.i2t) on renders of the training family. Method and file layout: docs/tracker.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "body/model.h"
#include "core/status.h"

namespace im2fit::lab {

struct TrainOptions {
  int image_count = 30000;  // >= 40
  int images_per_subject = 7;
  std::uint64_t seed = 1;
  int thread_count = 2;  // does not change the result
  // Jump forest
  int tree_count = 2;  // per joint; even: half of the trees learn on each half of the images
  int jump_count = 6;
  int samples_per_image = 10;
  int tree_depth_max = 13;
  // Cascade
  int level_count = 10;
  int level_tree_count = 600;
  int pixel_count = 400;
  int starts_per_image = 4;  // and of its mirror image
};

// Called now and then from the calling thread or a worker, one at a time: share of the work done (0..1), rising.
using TrainProgress = std::function<void(double share, std::string_view stage)>;

// The bytes of a .i2t file. Depends on the model and the options except thread_count. Errors: options out of range.
// 8,000 images with 400 trees a level take 137 s of processor time, three tenths of it for the person votes, and a
// gigabyte; time and memory grow with the images.
Result<std::vector<std::byte>> train_tracker(const body::BodyModel& model, const TrainOptions& options,
                                             const TrainProgress& progress = {});

}  // namespace im2fit::lab
