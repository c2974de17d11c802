// SPDX-License-Identifier: Apache-2.0
// Which frames need sensing while nothing moves. Decided from the frames and their times alone, so that the same
// frames give the same results on one thread and on two.
#pragma once

#include "core/camera.h"
#include "perception/observe/scene_change.h"

namespace im2fit {

enum class RestStep : int {
  sense,   // the normal case
  repeat,  // a periodic check of a still scene: the last detection holds
  pass,    // between two checks: the frame is only counted
};

// No allocation after construction, no threads.
class RestGate {
 public:
  RestGate(int width, int height) : change_(width, height) {}
  // `seconds` since the frame before; `nothing_to_do`: no person was in view when a frame was last sensed, or the
  // session waits for the measured person to leave. Any change is sensed at once, and every frame for kStillSeconds
  // after it.
  RestStep step(DepthView depth, float seconds, bool nothing_to_do);
  // Forces the next frame to be sensed.
  void wake();

 private:
  SceneChange change_;
  float still_s_ = 0;  // since the scene changed
  float nothing_to_do_s_ = 0;
  float sensed_s_ = 0;  // since a frame was sensed
  float looked_s_ = 0;  // since a look, or since a frame was sensed
};

}  // namespace im2fit
