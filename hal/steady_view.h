// SPDX-License-Identifier: Apache-2.0
// Stabilises the frames of a hand-held or moving camera that reports its pose: they are resampled to a static view.
// All later stages need a static camera: floor, people and the mean over frames.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/vec3.h"
#include "hal/source.h"

namespace im2fit::hal {

// Transforms between the axes of two cameras: rotation `turn` (row by row), then translation `step_mm`.
struct CameraMotion {
  std::array<float, 9> turn = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vec3f step_mm;
};
CameraMotion motion_between(const CameraPose& from, const CameraPose& to);

// + - * / and sqrt only: the same bits everywhere. One thread at a time.
class SteadyView {
 public:
  // If the camera has rotated or moved by more than this since its first pose, its frame begins a new view. Ten
  // degrees are a fifth of a phone's picture, which is lost at the edge.
  static constexpr float kTurnMaxDeg = 10, kStepMaxMm = 150;

  // A camera above kWalkMmS is carried (walks), until it is below kStandMmS; averaged over about kWalkingS.
  static constexpr float kWalkMmS = 150, kStandMmS = 80, kWalkingS = 0.3F;

  // Prepares for pictures of this size. Allocates.
  void prepare(int width, int height);
  // `walks`: each frame of a walking camera is a separate view. Otherwise it is resampled to the current view, as for
  // a hand-held camera, and newly visible surfaces are lost.
  void follow_walks(bool walks) { follow_walks_ = walks; }
  // The next pose begins a new view.
  void forget();
  // Takes the current pose, `seconds` after the last one. Returns whether the frame must be resampled.
  bool take(const CameraPose& pose, float seconds = 1.0F / 30);
  // The pose of the view. Call after take().
  const CameraPose& pose() const { return *first_; }
  // Converts a direction from the axes of the frame to those of the view.
  Vec3f in_view(Vec3f direction) const;
  // Resamples the frame in place (nearest neighbour), with the depths of the view; 0 outside the frame. Call after
  // take(). Surfaces that are hidden in the frame get the depth beside them, or none.
  void run(const Intrinsics& k, DepthImage frame);

 private:
  bool walking(const CameraPose& pose, float seconds);

  std::optional<CameraPose> first_;
  CameraMotion to_view_;  // from the frame's camera
  bool follow_walks_ = false, walks_ = false;
  std::optional<Vec3f> before_mm_;  // previous position of the camera
  Vec3f speed_mm_s_;                // smoothed
  std::vector<std::uint16_t> frame_;
};

}  // namespace im2fit::hal
