// SPDX-License-Identifier: Apache-2.0
// Joints steadied for display: the One Euro filter (Casiez, Roussel, Vogel: CHI 2012). Measuring never uses it: a
// low-pass trades noise for lag, a median over still frames needs no such trade.
#pragma once

#include <array>

#include "core/joints.h"

namespace im2fit {

// Nominal time between frames where a source has no clock.
inline constexpr float kFramePeriodS = 1.0F / 30.0F;

struct JointFilterSettings {
  float min_cutoff_hz = 1.5F;         // of a joint at rest: less trembles less and lags more
  float beta_hz_s_per_mm = 0.007F;    // how the cutoff rises with speed
  float derivative_cutoff_hz = 1.0F;  // of the speed's own estimate
  float jump_mm = 300.0F;             // further in one frame (9 m/s at 30 Hz): no movement, the filter starts anew
  float gap_max_s = 0.5F;             // longer without a frame: the same
};

// A joint that moves at `speed_mm_s` is shown where it was this long ago: a first-order low-pass of cutoff fc lags by
// 1/(2 pi fc), exactly so for a steady ramp sampled at any rate. Default settings: 106 ms at rest, 40 ms at 0.36 m/s,
// 19 ms at 1 m/s, 10 ms at 2 m/s.
float joint_filter_lag_ms(const JointFilterSettings& settings, float speed_mm_s);

// One low-pass per joint over the three coordinates together: its cutoff follows the joint's speed in space. No
// allocation; not shareable between threads; + - * / sqrt only.
class JointFilter {
 public:
  explicit JointFilter(const JointFilterSettings& settings = {}) : settings_(settings) {}
  // Forgets everything: after a loss.
  void reset() { started_ = false; }
  // `dt_s` since the last call; kFramePeriodS when not known. Confidences pass through. The first joints after a
  // reset or a gap, and a joint that jumped, pass unfiltered; so do joints that are not finite.
  JointSet step(const JointSet& joints, float dt_s);

 private:
  struct State {
    Vec3f raw;       // last seen
    Vec3f filtered;  // last answered
    Vec3f velocity;  // mm/s, filtered
  };
  JointFilterSettings settings_;
  std::array<State, kJointCount> states_{};
  bool started_ = false;
};

}  // namespace im2fit
