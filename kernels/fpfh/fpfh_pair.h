// SPDX-License-Identifier: Apache-2.0
// One pair's bins in float and without trigonometry: the careful way, for pairs the fast path leaves aside.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/core/vec3.h"
#include "kernels/fpfh/fpfh.h"

namespace im2fit::fpfh_detail {

struct PairBins {
  int f1, f2, f3;
};
inline constexpr PairBins kDegenerateBins = {kFpfhBins / 2, kFpfhBins / 2, kFpfhBins / 2};

// The edges of f1's bins above zero: angles (2k + 1) pi / 11.
inline constexpr int kEdgeCount = 5;
inline constexpr std::array<float, kEdgeCount> kEdgeCos = {0.959492974F, 0.654860734F, 0.142314838F, -0.415415013F,
                                                           -0.841253533F};
inline constexpr std::array<float, kEdgeCount> kEdgeSin = {0.281732557F, 0.755749574F, 0.989821442F, 0.909631995F,
                                                           0.540640817F};

// floor(11 (f + 1) / 2), clamped; NaN gives 0.
inline int cosine_bin(float f) {
  const float position = f * 5.5F + 5.5F;
  if (!(position >= 0.0F)) return 0;
  return position >= 10.0F ? 10 : static_cast<int>(position);
}

// floor(11 (atan2(y, x) + pi) / 2pi), clamped: the angle |atan2| is above an edge when sin(angle - edge) > 0, and the
// bins are symmetric about the middle one.
inline int angle_bin(float y, float x) {
  if (std::isnan(y) || std::isnan(x)) return 0;
  int passed = 0;
  for (std::size_t k = 0; k < kEdgeCount; ++k)
    passed += (std::fabs(y) * kEdgeCos[k] - x * kEdgeSin[k] > 0.0F) ? 1 : 0;
  return std::signbit(y) ? 5 - passed : 5 + passed;
}

// Source p: PCL's order of operations, comparing |a1| < |a2| instead of the arc cosines (which are NaN above 1).
inline PairBins pair_bins(Vec3f p, Vec3f p_normal, Vec3f q, Vec3f q_normal) {
  Vec3f d = q - p;
  const float length = norm(d);
  if (length == 0.0F) return kDegenerateBins;
  const float a1 = dot(p_normal, d) / length;
  const float a2 = dot(q_normal, d) / length;
  const bool swap = std::fabs(a1) < std::fabs(a2) && std::fabs(a2) <= 1.0F;
  const Vec3f source = swap ? q_normal : p_normal;
  const Vec3f target = swap ? p_normal : q_normal;
  if (swap) d = -d;
  Vec3f v = cross(d, source);
  const float v_length = norm(v);
  if (v_length == 0.0F) return kDegenerateBins;
  v = {v.x / v_length, v.y / v_length, v.z / v_length};
  const Vec3f w = cross(source, v);
  return {angle_bin(dot(w, target), dot(source, target)), cosine_bin(dot(v, target)), cosine_bin(swap ? -a2 : a1)};
}

}  // namespace im2fit::fpfh_detail
