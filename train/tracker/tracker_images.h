// SPDX-License-Identifier: Apache-2.0
// Pictures the tracker learns from: rendered, segmented and downsampled exactly as on the device.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "body/model.h"
#include "core/joints.h"
#include "perception/joints/view.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"
#include "train/tracker/tracker_scenes.h"

namespace im2fit::lab {

struct TrackerImage {
  joints::View view;
  std::array<Vec3f, kJointCount> truth;  // left and right as if facing the camera: exchanged when `back`
  bool back = false;
};

// A frame as the program sees it: upright.
struct UprightFrame {
  Intrinsics intrinsics;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> truth_mask;
  JointSet joints;
};

// Renders one scene after the other with the buffers of those before. Not shareable between threads; the model must
// outlive it.
class Studio {
 public:
  explicit Studio(const body::BodyModel& model) : model_(model) {}
  // `rest`: of the subject, as draw_subject() leaves it.
  UprightFrame render(const Subject& subject, std::span<const Vec3f> rest, const TrackerScene& drawn);

 private:
  const body::BodyModel& model_;
  std::vector<std::unique_ptr<VirtualScene>> scenes_;  // one for each size of picture met
};

// Half of either mask at least is both's: otherwise the segmenter took something else.
bool overlap(const std::vector<std::uint8_t>& mask, const std::vector<std::uint8_t>& truth);

// Scenes of training_mix() (train/tracker/tracker_scenes.h) with subject image / images_per_subject. Masks:
// most from the segmenter, some the truth.
std::vector<TrackerImage> render_tracker_images(const body::BodyModel& model, int image_count, int images_per_subject,
                                                std::uint64_t seed, int thread_count,
                                                const std::function<void(double)>& progress);

// The same picture in a mirror, with the names of left and right exchanged: a person as likely as the first.
TrackerImage mirrored(const TrackerImage& image);

}  // namespace im2fit::lab
