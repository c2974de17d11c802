// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/moments/moments.h"

namespace im2fit {
namespace {

// Sums of degrees 1 and 2 stay in 32 bits for kBlock vectors: 64 * 4095^2 < 2^30.
constexpr int kBlock = 64;
struct Low {
  __m256i count, x, y, xx, xy, yy;
};
struct High {
  __m256i sum[9];  // degrees 3 and 4, in the contract's order
};

inline std::int64_t sum64(__m256i a) {
  const __m128i half = _mm_add_epi64(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
  return _mm_cvtsi128_si64(half) + _mm_extract_epi64(half, 1);
}
inline std::int64_t sum32(__m256i a) {
  return sum64(_mm256_add_epi64(_mm256_cvtepi32_epi64(_mm256_castsi256_si128(a)),
                                _mm256_cvtepi32_epi64(_mm256_extracti128_si256(a, 1))));
}

// Every other point: mul_epi32 takes the lower half of each 64 bits.
inline void add_high(High& h, __m256i x, __m256i y, __m256i xx, __m256i xy, __m256i yy) {
  const __m256i a[9] = {xx, xx, yy, yy, xx, xx, xx, xy, yy}, b[9] = {x, y, x, y, xx, xy, yy, yy, yy};
  for (int i = 0; i < 9; ++i) h.sum[i] = _mm256_add_epi64(h.sum[i], _mm256_mul_epi32(a[i], b[i]));
}

inline void add(Low& l, High& h, __m256i pairs, __m256i first_x, __m256i last_x) {
  const __m256i all_x = _mm256_srai_epi32(_mm256_slli_epi32(pairs, 16), 16);
  const __m256i out = _mm256_or_si256(_mm256_cmpgt_epi32(first_x, all_x), _mm256_cmpgt_epi32(all_x, last_x));
  const __m256i kept = _mm256_andnot_si256(out, pairs);
  // As pairs of 16 bits (x, 0) and (y, 0), so that madd multiplies: half the cost of a 32-bit product.
  const __m256i x0 = _mm256_and_si256(kept, _mm256_set1_epi32(0xFFFF)), y0 = _mm256_srli_epi32(kept, 16);
  const __m256i xx = _mm256_madd_epi16(x0, x0), xy = _mm256_madd_epi16(x0, y0), yy = _mm256_madd_epi16(y0, y0);
  const __m256i x = _mm256_andnot_si256(out, all_x), y = _mm256_srai_epi32(kept, 16);
  l.count = _mm256_sub_epi32(l.count, _mm256_xor_si256(out, _mm256_set1_epi32(-1)));
  l.x = _mm256_add_epi32(l.x, x);
  l.y = _mm256_add_epi32(l.y, y);
  l.xx = _mm256_add_epi32(l.xx, xx);
  l.xy = _mm256_add_epi32(l.xy, xy);
  l.yy = _mm256_add_epi32(l.yy, yy);
  add_high(h, x, y, xx, xy, yy);
  add_high(h, _mm256_srli_epi64(x, 32), _mm256_srli_epi64(y, 32), _mm256_srli_epi64(xx, 32),
           _mm256_srli_epi64(xy, 32), _mm256_srli_epi64(yy, 32));
}

}  // namespace

void moments_avx2(const SectionPoint* points, int count, int first_x, int last_x, std::int64_t* sums) {
  const __m256i zero = _mm256_setzero_si256();
  const __m256i first = _mm256_set1_epi32(first_x), last = _mm256_set1_epi32(last_x);
  std::int64_t low[6] = {};
  High high = {{zero, zero, zero, zero, zero, zero, zero, zero, zero}};
  for (int begin = 0; begin < count; begin += 8 * kBlock) {
    Low l = {zero, zero, zero, zero, zero, zero};
    const int end = count - begin < 8 * kBlock ? count : begin + 8 * kBlock;
    int n = begin;
    for (; n + 8 <= end; n += 8)
      add(l, high, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(points + n)), first, last);
    if (n < end) {
      // Lanes past the end load as (0, 0); only the count can tell them from points.
      const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
      const __m256i some = _mm256_cmpgt_epi32(_mm256_set1_epi32(end - n), lane);
      add(l, high, _mm256_maskload_epi32(reinterpret_cast<const int*>(points + n), some), first, last);
      if (first_x <= 0 && last_x >= 0) low[0] -= 8 - (end - n);
    }
    const __m256i of_block[6] = {l.count, l.x, l.y, l.xx, l.xy, l.yy};
    for (int i = 0; i < 6; ++i) low[i] += sum32(of_block[i]);
  }
  for (int i = 0; i < 6; ++i) sums[i] = low[i];
  for (int i = 0; i < 9; ++i) sums[6 + i] = sum64(high.sum[i]);
}

}  // namespace im2fit
