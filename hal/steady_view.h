// SPDX-License-Identifier: Apache-2.0
// Steadies a hand-held or moving camera that reports its pose: its frames are converted to those of a camera at rest.
// All later stages rely on a camera at rest: floor, people and the mean over frames.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/vec3.h"
#include "hal/source.h"

namespace im2fit::hal {

// From the axes of one camera to those of another: directions by `turn`, row by row, points then by `step_mm`.
struct CameraMotion {
  std::array<float, 9> turn = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vec3f step_mm;
};
CameraMotion motion_between(const CameraPose& from, const CameraPose& to);

// + - * / and sqrt only: the same bits everywhere. One thread at a time.
class SteadyView {
 public:
  // A camera that has turned or moved further than this from its first pose shows another scene: its frame is the
  // first of a new view. Ten degrees are a fifth of a phone's picture, which is lost at its edge.
  static constexpr float kTurnMaxDeg = 10, kStepMaxMm = 150;

  // A camera carried faster than this is walking, until it is plainly slower; measured over some kWalkingS.
  static constexpr float kWalkMmS = 150, kStandMmS = 80, kWalkingS = 0.3F;

  // For pictures of this size; allocates.
  void prepare(int width, int height);
  // `walks`: each frame of a walking camera is a view of its own. Else it is changed to the view like that of a hand
  // that trembles, and what a step uncovers is lost.
  void follow_walks(bool walks) { follow_walks_ = walks; }
  // The next pose becomes the pose at rest.
  void forget();
  // Where the camera is now, `seconds` after the last one. Returns whether its frames are to be changed.
  bool take(const CameraPose& pose, float seconds = 1.0F / 30);
  // Of the view: the pose at rest. After take().
  const CameraPose& pose() const { return *first_; }
  // A direction in the axes of the frame, in those of the view.
  Vec3f in_view(Vec3f direction) const;
  // In place, after take(): each pixel of the view is the one whose ray meets it (nearest sample), with the depth it
  // has there; 0 outside the frame. A surface that a step aside uncovers has what lies beside it, or nothing.
  void run(const Intrinsics& k, DepthImage frame);

 private:
  bool walking(const CameraPose& pose, float seconds);

  std::optional<CameraPose> first_;
  CameraMotion to_view_;  // from the frame's camera
  bool follow_walks_ = false, walks_ = false;
  std::optional<Vec3f> before_mm_;  // where the camera was
  Vec3f speed_mm_s_;                // smoothed
  std::vector<std::uint16_t> frame_;
};

}  // namespace im2fit::hal
