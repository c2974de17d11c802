// SPDX-License-Identifier: Apache-2.0
// Which frames need sensing while nothing moves. Decided from the frames and their times alone, so that the same
// frames give the same results on one thread and on two.
#pragma once

#include "core/camera.h"
#include "perception/observe/scene_change.h"

namespace im2fit {

enum class RestStep : int {
  sense,   // as ever
  repeat,  // one of the looks at a scene that stands still: what was sensed last holds
  pass,    // between two looks: the frame is counted, no more
};

// No allocation after construction, no threads.
class RestGate {
 public:
  RestGate(int width, int height) : change_(width, height) {}
  // `seconds` since the frame before; `nothing_to_do`: no person was in view when a frame was last sensed, or the
  // session waits for who was measured to leave. Any change is sensed at once, and for kStillSeconds after it every
  // frame.
  RestStep step(DepthView depth, float seconds, bool nothing_to_do);
  // The next frame is sensed, whatever it shows.
  void wake();

 private:
  SceneChange change_;
  float still_s_ = 0;  // since the scene changed
  float nothing_to_do_s_ = 0;
  float sensed_s_ = 0;  // since a frame was sensed
  float looked_s_ = 0;  // since a look, or since a frame was sensed
};

}  // namespace im2fit
