// SPDX-License-Identifier: Apache-2.0
// Steadies a hand-held or moving camera that reports its pose: its frames are converted to those of a camera at rest.
// All later stages rely on a camera at rest: floor, people and the mean over frames.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/vec3.h"

namespace im2fit::hal {

// From the axes of a frame (x right, y down, z forward) to those of a place at rest: directions by a unit quaternion,
// then `position_mm`, where the camera is.
struct CameraPose {
  float x = 0, y = 0, z = 0, w = 1;
  Vec3f position_mm;
};
// Of the picture turned upright: hal/source.h.
CameraPose rotate_upright(const CameraPose& delivered, int rotate_deg);

// + - * / only: the same bits everywhere. One thread at a time.
class SteadyView {
 public:
  // A camera that has turned or moved further than this from its first pose shows another scene: its frame is the
  // first of a new view. Ten degrees are a fifth of a phone's picture, which is lost at its edge.
  static constexpr float kTurnMaxDeg = 10, kStepMaxMm = 150;

  // For pictures of this size; allocates.
  void prepare(int width, int height);
  // The next pose becomes the pose at rest.
  void forget() { first_.reset(); }
  // Where the camera is now. Returns whether its frames are to be changed.
  bool take(const CameraPose& pose);
  // A direction in the axes of the frame, in those of the view.
  Vec3f in_view(Vec3f direction) const;
  // In place, after take(): each pixel of the view is the one whose ray meets it (nearest sample), with the depth it
  // has there; 0 outside the frame. A surface that a step aside uncovers has what lies beside it, or nothing.
  void run(const Intrinsics& k, DepthImage frame);

 private:
  std::optional<CameraPose> first_;
  // Row by row, from the axes of the frame to the view's.
  std::array<float, 9> turn_ = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vec3f step_mm_;  // of the camera, in the view's axes
  std::vector<std::uint16_t> frame_;
};

}  // namespace im2fit::hal
