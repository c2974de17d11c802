// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/code_bounds/code_bounds.h"

namespace im2fit {

void code_bounds_avx2(const std::int32_t* blocks, int block_count, const std::int32_t* place, int dimension_count,
                      std::uint32_t* out) {
  const __m256i limit = _mm256_set1_epi32(kBoundGapMax);
  for (int b = 0; b < block_count; ++b, out += kBoxBlock) {
    __m256i sum = _mm256_setzero_si256();
    for (int d = 0; d < dimension_count; ++d, blocks += 2 * kBoxBlock) {
      const __m256i low = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(blocks));
      const __m256i high = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(blocks + kBoxBlock));
      const __m256i p = _mm256_set1_epi32(place[d]);
      __m256i gap = _mm256_max_epi32(_mm256_sub_epi32(low, p), _mm256_sub_epi32(p, high));
      gap = _mm256_srai_epi32(_mm256_max_epi32(gap, _mm256_setzero_si256()), 4);
      gap = _mm256_min_epi32(gap, limit);
      // Below 2^15: the pair product is the square.
      sum = _mm256_add_epi32(sum, _mm256_madd_epi16(gap, gap));
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), sum);
  }
}

}  // namespace im2fit
