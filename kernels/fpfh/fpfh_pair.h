// SPDX-License-Identifier: Apache-2.0
// One pair's bins in float and without trigonometry: the careful way, for pairs the fast path leaves aside.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/vec3.h"
#include "kernels/fpfh/fpfh.h"
#include "kernels/fpfh/fpfh_constants.h"

namespace im2fit::fpfh_detail {

struct PairBins {
  int f1, f2, f3;
};
inline constexpr PairBins kDegenerateBins = {kFpfhBins / 2, kFpfhBins / 2, kFpfhBins / 2};

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
  for (int k = 0; k < kEdgeCount; ++k) passed += (std::fabs(y) * kEdgeCosine[k] - x * kEdgeSine[k] > 0.0F) ? 1 : 0;
  return std::signbit(y) ? 5 - passed : 5 + passed;
}

// PCL's sums of three products, as its vector unit adds them.
inline float dot_xzy(Vec3f a, Vec3f b) {
  return (a.x * b.x + a.z * b.z) + a.y * b.y;
}

// Arc cosine of a in 0..1 as PCL's libm rounds it: the rational approximation of Sun's fdlibm (1993), which acosf of
// glibc to 2.40 evaluates in this order. Its own error (below one ulp) decides ties, so a better one would not do.
inline float arc_cosine(float a) {
  constexpr float kHalfPiHigh = 1.5707962513F, kHalfPiLow = 7.5497894159e-08F;
  // (asin(x) - x) / x^3 at z = x^2 <= 1/4.
  const auto series = [](float z) {
    const float p =
        1.6666667163e-01F +
        z * (-3.2556581497e-01F +
             z * (2.0121252537e-01F + z * (-4.0055535734e-02F + z * (7.9153501429e-04F + z * 3.4793309169e-05F))));
    const float q =
        1.0F + z * (-2.4033949375F + z * (2.0209457874F + z * (-6.8828397989e-01F + z * 7.7038154006e-02F)));
    return z * p / q;
  };
  if (a < 0.5F) return kHalfPiHigh - (a - (kHalfPiLow - a * series(a * a)));
  if (a == 1.0F) return 0.0F;
  const float z = (1.0F - a) * 0.5F;
  const float root = std::sqrt(z);
  const float head = std::bit_cast<float>(std::bit_cast<std::uint32_t>(root) & 0xFFFFF000U);  // its square is exact
  const float tail = (z - head * head) / (root + head);
  return 2.0F * (head + (series(z) * root + tail));
}

// acosf(|a1|) > acosf(|a2|): between nearly equal normals (planes, quantised depth) many rounded arc cosines are
// equal though the cosines are not, and f3's sign hangs on it. False where a2 is above 1 (a NaN in PCL).
inline bool swaps(float a1, float a2) {
  const float size1 = std::fabs(a1), size2 = std::fabs(a2);
  return size1 < size2 && size2 <= 1.0F && arc_cosine(size1) > arc_cosine(size2);
}

// Source p, in PCL's order of operations.
inline PairBins pair_bins(Vec3f p, Vec3f p_normal, Vec3f q, Vec3f q_normal) {
  Vec3f d = q - p;
  const float length = std::sqrt(dot_xzy(d, d));
  if (length == 0.0F) return kDegenerateBins;
  const float a1 = dot_xzy(p_normal, d) / length;
  const float a2 = dot_xzy(q_normal, d) / length;
  const bool swap = swaps(a1, a2);
  const Vec3f source = swap ? q_normal : p_normal;
  const Vec3f target = swap ? p_normal : q_normal;
  if (swap) d = -d;
  Vec3f v = cross(d, source);
  const float v_length = std::sqrt(dot_xzy(v, v));
  if (v_length == 0.0F) return kDegenerateBins;
  v = {v.x / v_length, v.y / v_length, v.z / v_length};
  const Vec3f w = cross(source, v);
  return {angle_bin(dot_xzy(w, target), dot_xzy(source, target)), cosine_bin(dot_xzy(v, target)),
          cosine_bin(swap ? -a2 : a1)};
}

}  // namespace im2fit::fpfh_detail
