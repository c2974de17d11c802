// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/blocks/blocks_lines.h"

namespace im2fit {
namespace {

__m256i load(const std::uint16_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
void store(void* p, __m256i v) {
  _mm256_storeu_si256(static_cast<__m256i*>(p), v);
}
__m256i seen_at(const Rows& rows, int v, int u) {
  const __m128i m = _mm_loadu_si128(reinterpret_cast<const __m128i*>(rows.mask + v * rows.mask_stride + u));
  return _mm256_and_si256(load(rows.depth + v * rows.depth_stride + u), _mm256_cvtepi8_epi16(m));
}

bool find_nearest(const Rows& rows, int u, Lines& lines) {
  const __m256i none = _mm256_set1_epi16(-1);
  __m256i nearest = none;
  for (int v = 0; v < rows.step; ++v)
    nearest = _mm256_min_epu16(nearest, _mm256_add_epi16(seen_at(rows, v, u), none));  // 0 becomes 65535
  store(lines.nearest_less_1 + u, nearest);
  return _mm256_testc_si256(nearest, none) == 0;
}

void sum_columns(const Rows& rows, int u, Lines& lines) {
  const __m256i limit = load(lines.limit + u), zero = _mm256_setzero_si256();
  __m256i low = zero, high = zero, count = zero;
  for (int v = 0; v < rows.step; ++v) {
    const __m256i seen = seen_at(rows, v, u);
    const __m256i near = _mm256_cmpeq_epi16(_mm256_min_epu16(seen, limit), seen);
    const __m256i taken = _mm256_and_si256(seen, near);
    low = _mm256_add_epi32(low, _mm256_unpacklo_epi16(taken, zero));
    high = _mm256_add_epi32(high, _mm256_unpackhi_epi16(taken, zero));
    count = _mm256_sub_epi16(count, _mm256_andnot_si256(_mm256_cmpeq_epi16(seen, zero), near));
  }
  store(lines.sum + u, _mm256_permute2x128_si256(low, high, 0x20));
  store(lines.sum + u + 8, _mm256_permute2x128_si256(low, high, 0x31));
  store(lines.count + u, count);
}

}  // namespace

void blocks_avx2(DepthView depth_q4, MaskView mask, const BlockGrid& grid, std::uint32_t* sum_q4,
                 std::uint16_t* count) {
  all_blocks<16>(depth_q4, mask, grid, sum_q4, count);
}

}  // namespace im2fit
