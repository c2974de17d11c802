// SPDX-License-Identifier: Apache-2.0
// How fast a person moves, from joints that tremble more from frame to frame than a person may move in a second.
#pragma once

#include <array>

#include "core/joints.h"

namespace im2fit {

struct Motion {
  float body_mm_s = 0;  // of the body's middle
  float limb_mm_s = 0;  // of the fastest elbow, hand, knee or foot that is seen
};

// Speeds as the distance between the means of the older and the newer half of the last kFrameCount frames, over the
// time between the middles of both: with tremor sd s a frame and 30 frames a second its own sd is 1.9 s per second,
// where one frame's difference has 42 s. It lags by kFrameCount/2 frames, 0.27 s. No allocation; not shareable
// between threads; + - * / sqrt only.
class MotionFilter {
 public:
  static constexpr int kFrameCount = 16;

  void reset() { count_ = 0; }
  // `body_mm`: the middle of the person's visible surface. Joints are unreliable when a person turns or bends; the
  // middle of a mask stays reliable. `dt_s` since the last call. Zero until kFrameCount frames are seen; also for a
  // limb not seen in all of them (confidence below kJointSeenMin) or that jumped (kJumpMm in a frame: tracker error).
  Motion step(Vec3f body_mm, const JointSet& joints, float dt_s);

  static constexpr float kJumpMm = 200.0F;

 private:
  // Elbows, hands, knees and feet, then the body's middle.
  static constexpr std::size_t kPointCount = 9;
  struct Frame {
    std::array<Vec3f, kPointCount> position_mm{};
    std::array<bool, kPointCount> seen{};
    float time_s = 0;
  };
  float speed_of(std::size_t point) const;
  const Frame& back(int frames_ago) const;

  std::array<Frame, kFrameCount> frames_{};
  int next_ = 0;
  int count_ = 0;
};

}  // namespace im2fit
