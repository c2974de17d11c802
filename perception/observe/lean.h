// SPDX-License-Identifier: Apache-2.0
// How far a person leans or bends, from the visible surface: head over legs. The joint model is learned from upright
// people and straightens people who bend.
#pragma once

#include "core/camera.h"
#include "perception/segment/segment.h"

namespace im2fit {

struct Lean {
  bool seen = false;  // floor, head and legs are seen
  float tangent =
      0;  // distance along the floor from the middle of the legs to the head, over the height between them
};

// `mask` of the person in `depth`. `head`: the user whose mask it is, when known; without has_head the topmost part
// of the mask is the head. Upright people have 0.09 at most, because of where the mean surfaces of head and shins
// lie; trunks bent by 28 degrees and more have at least 0.2. No allocation, thread-safe; + - * / sqrt only.
Lean lean_of(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Person& person, const User* head);

}  // namespace im2fit
