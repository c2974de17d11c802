// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/code_bounds/code_bounds.h"

namespace im2fit {
namespace {

inline __m256i load(const std::int16_t* edges) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(edges));
}

}  // namespace

void code_bounds_avx2(const std::int16_t* blocks, int block_count, const std::int16_t* place, int dimension_count,
                      std::int32_t* out) {
  const __m256i limit = _mm256_set1_epi16(kCodeGapMax), zero = _mm256_setzero_si256();
  for (int b = 0; b < block_count; ++b, out += kBoxBlock) {
    // Boxes 0-3 and 8-11; 4-7 and 12-15.
    __m256i even = zero, odd = zero;
    for (int d = 0; d < dimension_count; ++d, blocks += 2 * kBoxBlock) {
      const __m256i p = _mm256_set1_epi16(place[d]);
      const __m256i past =
          _mm256_max_epi16(_mm256_sub_epi16(load(blocks), p), _mm256_sub_epi16(p, load(blocks + kBoxBlock)));
      const __m256i gap = _mm256_min_epi16(_mm256_max_epi16(past, zero), limit);
      const __m256i low = _mm256_unpacklo_epi16(gap, zero), high = _mm256_unpackhi_epi16(gap, zero);
      even = _mm256_add_epi32(even, _mm256_madd_epi16(low, low));
      odd = _mm256_add_epi32(odd, _mm256_madd_epi16(high, high));
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_permute2x128_si256(even, odd, 0x20));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + 8), _mm256_permute2x128_si256(even, odd, 0x31));
  }
}

}  // namespace im2fit
