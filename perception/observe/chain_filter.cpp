// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/chain_filter.h"

#include "core/joints.h"

namespace im2fit {
namespace {

constexpr float kLengthShare = 0.1F;  // of the newest frame in a bone's length: it converges in ten frames

}  // namespace

ChainedJoints ChainFilter::step(const JointSet& joints, float dt_s) {
  ChainedJoints out;
  out.joints = joints;
  const auto seen = [&](std::size_t j) { return joints.confidence[j] >= kJointSeenMin; };
  for (const Joint joint : kJointOrder) {
    if (joint == parent_of(joint)) continue;
    const std::size_t j = joint_index(joint);
    const std::size_t parent = joint_index(parent_of(joint));
    Bone& bone = bones_[j];
    if (seen(j)) {
      bone.unseen_s = 0;
      if (!seen(parent)) continue;  // an inferred parent teaches nothing about the bone
      bone.offset_mm = joints.position_mm[j] - joints.position_mm[parent];
      const float length = norm(bone.offset_mm);
      bone.length_mm = bone.length_mm > 0 ? bone.length_mm + (length - bone.length_mm) * kLengthShare : length;
      continue;
    }
    bone.unseen_s += dt_s;
    const float length = bone.length_mm > 0 ? bone.length_mm : bones_[joint_index(mirror_of(joint))].length_mm;
    out.inferred |= joint_bit(j);
    if (!(length > 0)) continue;
    const bool hold = bone.length_mm > 0 && bone.unseen_s <= kHoldS;
    // A held offset is a direction too: a bone seen foreshortened by noise comes back to its length.
    const Vec3f towards = hold ? bone.offset_mm : joints.position_mm[j] - out.joints.position_mm[parent];
    out.joints.position_mm[j] = out.joints.position_mm[parent] + normalized(towards) * length;
  }
  return out;
}

}  // namespace im2fit
