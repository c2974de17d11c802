// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/joints/trees/walk.h"

namespace im2fit::joints {
namespace {

inline __m256i widened(__m128i v) {
  return _mm256_cvtepi16_epi32(v);
}
inline __m128i eight(const std::int16_t* p) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
}

}  // namespace

void sum_leaves_avx2(const Split* splits, const std::int16_t* leaves, int tree_count, const std::int16_t* pixels,
                     std::int32_t* sum) {
  __m256i s[6];
  for (int i = 0; i < 6; ++i) s[i] = _mm256_setzero_si256();
  for_each_batch(splits, leaves, tree_count, pixels, [&s](const std::int16_t* const* found, int count) {
    __m256i a = s[0], b = s[1], c = s[2], d = s[3], e = s[4], f = s[5];
    for (int t = 0; t < count; ++t) {
      const std::int16_t* leaf = found[t];
      a = _mm256_add_epi32(a, widened(eight(leaf)));
      b = _mm256_add_epi32(b, widened(eight(leaf + 8)));
      c = _mm256_add_epi32(c, widened(eight(leaf + 16)));
      d = _mm256_add_epi32(d, widened(eight(leaf + 24)));
      e = _mm256_add_epi32(e, widened(eight(leaf + 32)));
      // Values 37..44: nothing past the leaf is read; 37..39 are dropped below.
      f = _mm256_add_epi32(f, widened(eight(leaf + 37)));
    }
    s[0] = a, s[1] = b, s[2] = c, s[3] = d, s[4] = e, s[5] = f;
  });
  for (int i = 0; i < 5; ++i) {
    __m256i* out = reinterpret_cast<__m256i*>(sum + 8 * i);
    _mm256_storeu_si256(out, _mm256_add_epi32(_mm256_loadu_si256(out), s[i]));
  }
  alignas(32) std::int32_t rest[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(rest), s[5]);
  for (int i = 3; i < 8; ++i) sum[37 + i] += rest[i];
}

}  // namespace im2fit::joints
