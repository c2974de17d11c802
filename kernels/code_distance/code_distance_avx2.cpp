// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/code_distance/code_distance.h"

namespace im2fit {
namespace {

struct PairWeights {
  __m256i high, low;
};

inline __m256i both(const std::int16_t* pair) {
  const std::uint32_t bits =
      static_cast<std::uint16_t>(pair[0]) | static_cast<std::uint32_t>(static_cast<std::uint16_t>(pair[1])) << 16;
  return _mm256_set1_epi32(static_cast<int>(bits));
}
// Eight points' pairs as 16-bit values.
inline __m256i eight_pairs(const std::int8_t* codes) {
  return _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(codes)));
}
// norm + square - (2^16 high + 2 low), four points.
inline void store_four(__m128i high, __m128i low, const std::int64_t* norm, __m256i square, std::int64_t* out) {
  const __m256i h = _mm256_slli_epi64(_mm256_cvtepi32_epi64(high), 16);
  const __m256i l = _mm256_slli_epi64(_mm256_cvtepi32_epi64(low), 1);
  const __m256i n = _mm256_add_epi64(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(norm)), square);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_sub_epi64(n, _mm256_add_epi64(h, l)));
}
inline void store_eight(__m256i high, __m256i low, const std::int64_t* norm, __m256i square, std::int64_t* out) {
  store_four(_mm256_castsi256_si128(high), _mm256_castsi256_si128(low), norm, square, out);
  store_four(_mm256_extracti128_si256(high, 1), _mm256_extracti128_si256(low, 1), norm + 4, square, out + 4);
}

}  // namespace

void code_distance_avx2(const std::int8_t* blocks, const std::int64_t* norm, int block_count, const CodeQuery& query,
                        std::int64_t* out) {
  PairWeights weights[kCodeDimensionMax / 2];
  const int pair_count = query.pair_count;
  const std::int16_t* weight = reinterpret_cast<const std::int16_t*>(&query.weight);
  for (int p = 0; p < pair_count; ++p) weights[p] = {both(weight + 4 * p), both(weight + 4 * p + 2)};
  const __m256i square = _mm256_set1_epi64x(query.square);
  for (int b = 0; b < block_count; ++b, norm += kCodeBlock, out += kCodeBlock) {
    __m256i h0 = _mm256_setzero_si256(), h1 = h0, l0 = h0, l1 = h0;
    for (int p = 0; p < pair_count; ++p, blocks += 2 * kCodeBlock) {
      const __m256i x = eight_pairs(blocks), y = eight_pairs(blocks + 16);
      const PairWeights w = weights[p];
      h0 = _mm256_add_epi32(h0, _mm256_madd_epi16(x, w.high));
      l0 = _mm256_add_epi32(l0, _mm256_madd_epi16(x, w.low));
      h1 = _mm256_add_epi32(h1, _mm256_madd_epi16(y, w.high));
      l1 = _mm256_add_epi32(l1, _mm256_madd_epi16(y, w.low));
    }
    store_eight(h0, l0, norm, square, out);
    store_eight(h1, l1, norm + 8, square, out + 8);
  }
}

}  // namespace im2fit
