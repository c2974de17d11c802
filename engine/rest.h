// SPDX-License-Identifier: Apache-2.0
// Decides which frames must be sensed while nothing moves. It uses only the frames and their times, so the same
// frames give the same results with one thread and with two.
#pragma once

#include "core/camera.h"
#include "perception/observe/scene_change.h"

namespace im2fit {

enum class RestStep : int {
  sense,   // the normal case
  repeat,  // periodic output in a still scene: the last detection is used again
  pass,    // all other frames of a still scene: the frame is only counted
};

// No allocation after construction, no threads.
class RestGate {
 public:
  RestGate(int width, int height) : change_(width, height) {}
  // `seconds`: since the previous frame. `nothing_to_do`: no person was in view in the last sensed frame, or the
  // session waits until the measured person leaves. A frame with a change is sensed at once, and so are all frames in
  // the following kStillSeconds.
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
