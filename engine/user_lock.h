// SPDX-License-Identifier: Apache-2.0
// Whose session it is, decided in stage SENSE so that it depends on the frames alone, not on how far FIT has come.
#pragma once

#include "perception/observe/observe.h"

namespace im2fit {

// Shorter flicker of the mask is no loss: half a second at 30 Hz. The session counts the same frames.
inline constexpr int kAbsentFramesMax = 15;

// Free: the nearest and most central person. From the first frame that needs nothing on, only that user,
// until absent for more than kAbsentFramesMax frames: then the session is LOST, and whoever comes next may begin one.
class UserLock {
 public:
  // `user`: measure this one only; 0: whoever stands right first.
  explicit UserLock(int user) : requested_(user), selected_(user) {}
  void reset() { *this = UserLock(requested_); }
  // From the next frame on; as the constructor.
  void request(int user) { *this = UserLock(user); }
  int requested() const { return requested_; }
  // Whom to sense in the next frame; 0: any person.
  int selected() const { return selected_; }
  void saw(const Detection& detection) {
    if (requested_ != 0) return;
    if (detection.person.found) {
      absent_frames_ = 0;
      if (selected_ == 0 && detection.guidance == 0) selected_ = detection.person.id;
    } else if (selected_ != 0 && ++absent_frames_ > kAbsentFramesMax) {
      reset();
    }
  }

 private:
  int requested_;
  int selected_;
  int absent_frames_ = 0;
};

}  // namespace im2fit
