// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/joint_filter.h"

namespace im2fit {
namespace {

constexpr float kTwoPi = 6.2831853F;

// Share of the new sample in a first-order low-pass: 1 / (1 + tau / dt), tau = 1 / (2 pi fc).
float share_of_new(float cutoff_hz, float dt_s) {
  const float turns = kTwoPi * cutoff_hz * dt_s;
  return turns / (turns + 1.0F);
}

Vec3f low_pass(Vec3f old, Vec3f fresh, float share) {
  return old + (fresh - old) * share;
}

}  // namespace

float joint_filter_lag_ms(const JointFilterSettings& settings, float speed_mm_s) {
  return 1000.0F / (kTwoPi * (settings.min_cutoff_hz + settings.beta_hz_s_per_mm * speed_mm_s));
}

JointSet JointFilter::step(const JointSet& joints, float dt_s) {
  JointSet out = joints;
  const bool fresh = !started_ || !(dt_s > 0) || dt_s > settings_.gap_max_s;
  started_ = true;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    State& s = states_[j];
    const Vec3f p = joints.position_mm[j];
    const Vec3f moved = p - s.raw;
    // Written so that a joint that is not a number starts anew as well.
    if (fresh || !(dot(moved, moved) <= settings_.jump_mm * settings_.jump_mm)) {
      s = {p, p, {}};
      continue;
    }
    // Speed from the raw samples: against the filtered one it would count the lag as movement.
    s.velocity = low_pass(s.velocity, moved * (1.0F / dt_s), share_of_new(settings_.derivative_cutoff_hz, dt_s));
    const float cutoff_hz = settings_.min_cutoff_hz + settings_.beta_hz_s_per_mm * norm(s.velocity);
    s.filtered = low_pass(s.filtered, p, share_of_new(cutoff_hz, dt_s));
    s.raw = p;
    out.position_mm[j] = s.filtered;
  }
  return out;
}

}  // namespace im2fit
