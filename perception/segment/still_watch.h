// SPDX-License-Identifier: Apache-2.0
// How far a figure's trunk has moved within the last seconds, in depth. People always sway, mostly forwards and back;
// of a mannequin or a poster only noise moves, and means over a third of a second leave little of that. No
// allocation.
#pragma once

#include "core/camera.h"

namespace im2fit::segment {

class StillWatch {
 public:
  // Where the trunk is sought: the figure's middle when the watch began, or has moved on since.
  Vec3f place_mm(Vec3f middle_mm);
  // Mean depth of the trunk about that place, in a frame that shows it unhidden; `seconds` since the frame before.
  void add(float depth_mm, float seconds);
  bool watched_long() const { return seconds_ >= kWatchedS; }
  float spread_mm() const;  // of the latest 3 to 6 seconds

 private:
  static constexpr float kWatchedS = 2.6F;
  static constexpr float kBlockS = 0.33F;
  static constexpr float kSpanS = 3.0F;
  static constexpr float kMovedOnMm = 80.0F;  // more than people sway

  struct Range {
    float low = 1e9F, high = -1e9F;
  };
  Vec3f place_mm_;
  bool placed_ = false;
  float sum_mm_ = 0;
  int count_ = 0;
  float block_s_ = 0;
  float span_s_ = 0;
  float seconds_ = 0;  // watched, all in all
  Range now_, before_;
};

}  // namespace im2fit::segment
