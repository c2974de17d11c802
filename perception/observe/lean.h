// SPDX-License-Identifier: Apache-2.0
// How far a person leans or bends, from what is seen of them: head over legs. Joints are learned from people who
// stand upright and straighten those who do not.
#pragma once

#include "core/camera.h"
#include "perception/segment/segment.h"

namespace im2fit {

struct Lean {
  bool seen = false;  // floor, head and legs are
  float tangent =
      0;  // distance along the floor from the middle of the legs to the head, over the height between them
};

// `mask` of the person in `depth`. `head`: the user whose mask it is, when known; without has_head what is topmost is
// the head. Upright people have 0.09 at most, as the mean surfaces of head and shins lie; trunks bent by 28 degrees
// and more at least 0.2. No allocation, thread-safe; + - * / sqrt only.
Lean lean_of(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Person& person, const User* head);

}  // namespace im2fit
