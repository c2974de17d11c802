// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/votes/votes.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

struct Eight {
  __m256 x, y, z, near, far;
};

// Lanes of -1 in `meets` vote.
void eight(const Eight& p, const __m256* q, __m256 lanes, Votes& out) {
  const __m256 along = _mm256_add_ps(_mm256_mul_ps(q[0], p.x), _mm256_mul_ps(q[1], p.y));
  const __m256 inverse = _mm256_xor_ps(_mm256_add_ps(along, q[2]), _mm256_set1_ps(-0.0F));
  const __m256 plane = _mm256_div_ps(_mm256_set1_ps(1.0F), inverse);
  const __m256 meets = _mm256_and_ps(lanes, _mm256_cmp_ps(inverse, _mm256_set1_ps(1e-5F), _CMP_GT_OQ));
  const __m256 away = _mm256_andnot_ps(_mm256_set1_ps(-0.0F), _mm256_sub_ps(p.z, plane));
  const __m256 end = _mm256_add_ps(_mm256_add_ps(plane, _mm256_set1_ps(80.0F)), p.far);
  const auto count = [&](__m256 mask) {
    return __builtin_popcount(static_cast<unsigned>(_mm256_movemask_ps(_mm256_and_ps(mask, meets))));
  };
  out.on += count(_mm256_cmp_ps(away, p.near, _CMP_LT_OQ));
  out.behind += count(_mm256_cmp_ps(p.z, end, _CMP_GT_OQ));
}

}  // namespace

void votes_avx2(const VotingPoints& points, const float* q, Votes& out) {
  const __m256 plane[3] = {_mm256_set1_ps(q[0]), _mm256_set1_ps(q[1]), _mm256_set1_ps(q[2])};
  Votes sum;
  const __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
  int i = 0;
  for (; i + kLanes <= points.count; i += kLanes) {
    eight({_mm256_loadu_ps(points.ray_x + i), _mm256_loadu_ps(points.ray_y + i), _mm256_loadu_ps(points.z_mm + i),
           _mm256_loadu_ps(points.near_mm + i), _mm256_loadu_ps(points.far_mm + i)},
          plane, all, sum);
  }
  if (i < points.count) {
    const __m256i left =
        _mm256_cmpgt_epi32(_mm256_set1_epi32(points.count - i), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const auto load = [&](const float* p) { return _mm256_maskload_ps(p + i, left); };
    eight({load(points.ray_x), load(points.ray_y), load(points.z_mm), load(points.near_mm), load(points.far_mm)},
          plane, _mm256_castsi256_ps(left), sum);
  }
  out = sum;
}

}  // namespace im2fit
