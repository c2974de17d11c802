// SPDX-License-Identifier: Apache-2.0
#include "train/population/reach.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace im2fit::lab {
namespace {

constexpr int kTurns = 24;
constexpr float kArmRadiusMm = 42;
constexpr float kHintMm = 40;  // an elbow opposite to the hint costs as much as twice this much depth, squared

float cost_of(Vec3f shoulder, Vec3f elbow, Vec3f wrist, const std::function<float(Vec3f)>& depth_inside) {
  float sum = 0;
  const auto add = [&](Vec3f p) {
    const float d = std::max(0.0F, depth_inside(p) + kArmRadiusMm);
    sum += d * d;
  };
  add(shoulder + (elbow - shoulder) * 0.75F);
  add(elbow);
  for (const float t : {0.25F, 0.5F, 0.75F, 1.0F}) add(elbow + (wrist - elbow) * t);
  return sum;
}

}  // namespace

Reach reach_for(Vec3f shoulder, float upper_mm, float lower_mm, Vec3f wrist, Vec3f elbow_hint,
                const std::function<float(Vec3f)>& depth_inside) {
  const Vec3f axis = normalized(wrist - shoulder);
  const float d =
      std::clamp(norm(wrist - shoulder), std::fabs(upper_mm - lower_mm) + 10, (upper_mm + lower_mm) * 0.995F);
  const Vec3f end = shoulder + axis * d;
  const float along = (upper_mm * upper_mm - lower_mm * lower_mm + d * d) / (2 * d);
  const float aside = std::sqrt(std::max(0.0F, upper_mm * upper_mm - along * along));
  const Vec3f first = normalized(elbow_hint - axis * dot(elbow_hint, axis));
  const Vec3f second = cross(axis, first);
  Vec3f best;
  float best_cost = 1e30F;
  for (int i = 0; i < kTurns; ++i) {
    const float a = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kTurns;
    const Vec3f elbow = shoulder + axis * along + (first * std::cos(a) + second * std::sin(a)) * aside;
    const float cost = cost_of(shoulder, elbow, end, depth_inside) + 2 * kHintMm * kHintMm * (1 - std::cos(a));
    if (cost < best_cost) {
      best_cost = cost;
      best = elbow;
    }
  }
  return {normalized(best - shoulder), normalized(end - best)};
}

}  // namespace im2fit::lab
