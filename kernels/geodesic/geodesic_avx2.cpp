// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/geodesic/geodesic.h"

namespace im2fit {
namespace {

// Parts of eight steps, each in the lower half of its lane, the upper one zero.
inline __m256i parts8(const std::int32_t* a) {
  const __m256i to = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a + 1));
  const __m256i from = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a));
  const __m256i step = _mm256_sub_epi32(to, from);
  const __m256i clamped =
      _mm256_max_epi32(_mm256_min_epi32(step, _mm256_set1_epi32(INT16_MAX)), _mm256_set1_epi32(INT16_MIN));
  return _mm256_and_si256(clamped, _mm256_set1_epi32(0xFFFF));
}

// The float root of a 32-bit number is within 0.006 of the real one (one rounding of the number, one of the root, of
// at most 56756), so its nearest whole number is off by one at most, which the exact remainder shows.
inline __m256i nearest_root8(__m256i square) {
  const __m256 high = _mm256_cvtepi32_ps(_mm256_srli_epi32(square, 16));
  const __m256 low = _mm256_cvtepi32_ps(_mm256_and_si256(square, _mm256_set1_epi32(0xFFFF)));
  const __m256 number = _mm256_add_ps(_mm256_mul_ps(high, _mm256_set1_ps(65536.0F)), low);
  const __m256i root = _mm256_cvtps_epi32(_mm256_sqrt_ps(number));
  const __m256i rest = _mm256_sub_epi32(square, _mm256_mullo_epi32(root, root));
  const __m256i more = _mm256_cmpgt_epi32(rest, root);                                              // -1: one more
  const __m256i enough = _mm256_cmpgt_epi32(_mm256_add_epi32(rest, root), _mm256_setzero_si256());  // 0: one less
  const __m256i less = _mm256_add_epi32(enough, _mm256_set1_epi32(1));
  // The root of 0 is not to be lessened.
  return _mm256_max_epi32(_mm256_sub_epi32(_mm256_sub_epi32(root, more), less), _mm256_setzero_si256());
}

inline __m256i lengths8(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z) {
  const __m256i xy = _mm256_or_si256(parts8(x), _mm256_slli_epi32(parts8(y), 16)), dz = parts8(z);
  return nearest_root8(_mm256_add_epi32(_mm256_madd_epi16(xy, xy), _mm256_madd_epi16(dz, dz)));
}

}  // namespace

std::uint32_t geodesic_avx2(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z, int count) {
  __m256i sum = _mm256_setzero_si256();
  int i = 0;
  for (; i + 9 <= count; i += 8) sum = _mm256_add_epi32(sum, lengths8(x + i, y + i, z + i));
  if (i + 1 < count) {
    // The last point again and again adds nothing.
    std::int32_t tail[3][9];
    for (int n = 0; n < 9; ++n) {
      const int from = i + n < count ? i + n : count - 1;
      tail[0][n] = x[from];
      tail[1][n] = y[from];
      tail[2][n] = z[from];
    }
    sum = _mm256_add_epi32(sum, lengths8(tail[0], tail[1], tail[2]));
  }
  alignas(32) std::uint32_t lanes[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(lanes), sum);
  std::uint32_t length = 0;
  for (int lane = 0; lane < 8; ++lane) length += lanes[lane];
  return length;
}

}  // namespace im2fit
