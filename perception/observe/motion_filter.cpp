// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/motion_filter.h"

#include "perception/observe/chain_filter.h"

namespace im2fit {
namespace {

constexpr std::array<Joint, 8> kLimbs = {Joint::LE, Joint::RE, Joint::LA, Joint::RA,
                                         Joint::LK, Joint::RK, Joint::LF, Joint::RF};
constexpr std::size_t kBodyPoint = kLimbs.size();

}  // namespace

const MotionFilter::Frame& MotionFilter::back(int frames_ago) const {
  return frames_[static_cast<std::size_t>((next_ - 1 - frames_ago + 2 * kFrameCount) % kFrameCount)];
}

float MotionFilter::speed_of(std::size_t point) const {
  constexpr int kHalf = kFrameCount / 2;
  Vec3f newer;
  Vec3f older;
  float newer_s = 0;
  float older_s = 0;
  for (int i = 0; i < kFrameCount; ++i) {
    const Frame& frame = back(i);
    const Vec3f p = frame.position_mm[point];
    if (!frame.seen[point]) return 0;
    if (i + 1 < kFrameCount) {
      const Vec3f moved = p - back(i + 1).position_mm[point];
      if (!(dot(moved, moved) <= kJumpMm * kJumpMm)) return 0;
    }
    (i < kHalf ? newer : older) = (i < kHalf ? newer : older) + p;
    (i < kHalf ? newer_s : older_s) += frame.time_s;
  }
  const float seconds = (newer_s - older_s) / static_cast<float>(kHalf);
  return seconds > 0 ? norm(newer - older) / (static_cast<float>(kHalf) * seconds) : 0.0F;
}

Motion MotionFilter::step(Vec3f body_mm, const JointSet& joints, float dt_s) {
  // Times count back from now, so that a float keeps its milliseconds all day.
  for (Frame& frame : frames_) frame.time_s -= dt_s;
  Frame& now = frames_[static_cast<std::size_t>(next_)];
  now = {};
  for (std::size_t i = 0; i < kLimbs.size(); ++i) {
    now.position_mm[i] = joints[kLimbs[i]];
    now.seen[i] = joints.confidence[joint_index(kLimbs[i])] >= kJointSeenMin;
  }
  now.position_mm[kBodyPoint] = body_mm;
  now.seen[kBodyPoint] = true;
  next_ = (next_ + 1) % kFrameCount;
  if (count_ < kFrameCount) ++count_;

  Motion motion;
  if (count_ < kFrameCount) return motion;
  motion.body_mm_s = speed_of(kBodyPoint);
  for (std::size_t i = 0; i < kLimbs.size(); ++i) {
    const float speed = speed_of(i);
    if (speed > motion.limb_mm_s) motion.limb_mm_s = speed;
  }
  return motion;
}

}  // namespace im2fit
