// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/code_distance/code_distance.h"

namespace im2fit {
namespace {

inline __m256i both(const std::int16_t* pair) {
  const std::uint32_t bits =
      static_cast<std::uint16_t>(pair[0]) | static_cast<std::uint32_t>(static_cast<std::uint16_t>(pair[1])) << 16;
  return _mm256_set1_epi32(static_cast<int>(bits));
}

// Eight points, two dimensions.
inline __m256i add_squares(__m256i sum, const std::int8_t* codes, __m256i step, __m256i place) {
  const __m256i code = _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(codes)));
  const __m256i gap = _mm256_abs_epi16(_mm256_sub_epi16(_mm256_mullo_epi16(code, step), place));
  const __m256i counted = _mm256_min_epi16(gap, _mm256_set1_epi16(kCodeGapMax));
  return _mm256_add_epi32(sum, _mm256_madd_epi16(counted, counted));
}

inline std::int32_t smallest_of(__m256i v) {
  const __m128i four = _mm_min_epi32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
  const __m128i two = _mm_min_epi32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(1, 0, 3, 2)));
  return _mm_cvtsi128_si32(_mm_min_epi32(two, _mm_shuffle_epi32(two, _MM_SHUFFLE(2, 3, 0, 1))));
}

}  // namespace

void code_distance_avx2(const std::int8_t* blocks, int block_count, const CodeQuery& query, std::int32_t* out,
                        std::int32_t* least) {
  __m256i step[kCodeDimensionMax / 2], place[kCodeDimensionMax / 2];
  const int pair_count = query.pair_count;
  for (int p = 0; p < pair_count; ++p) {
    step[p] = both(query.step.data() + 2 * p);
    place[p] = both(query.place.data() + 2 * p);
  }
  for (int b = 0; b < block_count; ++b, out += kCodeBlock) {
    __m256i first = _mm256_setzero_si256(), second = first;
    for (int p = 0; p < pair_count; ++p, blocks += 2 * kCodeBlock) {
      first = add_squares(first, blocks, step[p], place[p]);
      second = add_squares(second, blocks + kCodeBlock, step[p], place[p]);
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), first);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + 8), second);
    least[b] = smallest_of(_mm256_min_epi32(first, second));
  }
}

}  // namespace im2fit
