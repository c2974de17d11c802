// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/trees/walk.h"

namespace im2fit::joints {
namespace {

inline __m256i sixteen(const std::int8_t* p) {
  return _mm256_cvtepi8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
}
inline void add_eight(std::int32_t* out, __m128i v) {
  __m256i* to = reinterpret_cast<__m256i*>(out);
  _mm256_storeu_si256(to, _mm256_add_epi32(_mm256_loadu_si256(to), _mm256_cvtepi16_epi32(v)));
}

}  // namespace

void sum_leaves_avx2(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                     int run_count, std::int32_t* sum) {
  for_each_batch(splits, leaves, tree_count, pixels, run_count, [&](const LeafBatch& batch) {
    for (int r = 0; r < run_count; ++r) {
      __m256i low = _mm256_setzero_si256(), high = low;  // a batch fits 16 bits
      for (int t = 0; t < batch.count; ++t) {
        const std::int8_t* leaf = batch.leaf(t, r);
        low = _mm256_add_epi16(low, sixteen(leaf));
        high = _mm256_add_epi16(high, sixteen(leaf + 16));
      }
      std::int32_t* to = sum + r * kLeafSize;
      add_eight(to, _mm256_castsi256_si128(low));
      add_eight(to + 8, _mm256_extracti128_si256(low, 1));
      add_eight(to + 16, _mm256_castsi256_si128(high));
      add_eight(to + 24, _mm256_extracti128_si256(high, 1));
    }
  });
}

}  // namespace im2fit::joints
