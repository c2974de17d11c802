// SPDX-License-Identifier: Apache-2.0
// Joints the camera does not see (occluded, out of the picture) held by the skeleton: at the bone's known length from
// the parent, where they were last seen. For display and for callers; measuring takes the tracker's joints as they
// are.
#pragma once

#include <array>
#include <cstdint>

#include "core/joints.h"

namespace im2fit {

// Below this chance of being within 50 mm a joint is inferred instead of taken from the tracker.
inline constexpr float kJointSeenMin = 0.25F;

// Bit by Joint.
using JointFlags = std::uint32_t;
constexpr JointFlags joint_bit(std::size_t joint) {
  return JointFlags{1} << joint;
}

struct ChainedJoints {
  JointSet joints;
  JointFlags inferred = 0;
};

// No allocation; not shareable between threads; + - * / sqrt only.
class ChainFilter {
 public:
  void reset() { *this = {}; }
  // Seen joints pass unchanged and teach the bone to their parent (length: running mean; direction: the latest). A
  // joint of little confidence keeps that direction for kHoldS, and takes the tracker's afterwards, always at the
  // bone's length from its parent; where its bone was never seen, its mirror image's length stands in, and without
  // that the tracker's joint stands. Confidences stay the tracker's: small for what is inferred. The torso has no
  // parent and is never inferred. `dt_s` since the last call.
  ChainedJoints step(const JointSet& joints, float dt_s);

  static constexpr float kHoldS = 1.0F;

 private:
  struct Bone {
    float length_mm = 0;  // 0: never seen
    Vec3f offset_mm;      // from the parent when last seen
    float unseen_s = 0;
  };
  std::array<Bone, kJointCount> bones_{};  // by the joint at their far end
};

}  // namespace im2fit
