// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/project/project.h"

namespace im2fit {
namespace {

inline __m256i sixteen(const std::int16_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
// Eight sums in two halves, so that nothing has to be widened: 2^16 high + low.
struct Sums {
  __m256i high, low;
};
inline void add(Sums& s, __m256i pair_sums) {
  s.high = _mm256_add_epi32(s.high, _mm256_srai_epi32(pair_sums, 16));
  s.low = _mm256_add_epi32(s.low, _mm256_and_si256(pair_sums, _mm256_set1_epi32(0xFFFF)));
}
inline std::int64_t total(const Sums& s) {
  alignas(32) std::int32_t high[8], low[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(high), s.high);
  _mm256_store_si256(reinterpret_cast<__m256i*>(low), s.low);
  std::int64_t sum = 0;
  for (int i = 0; i < 8; ++i) sum += std::int64_t{high[i]} * 65536 + low[i];
  return sum;
}

}  // namespace

void project_avx2(const std::int16_t* feature, const std::int16_t* weights, int stride, int row_count,
                  std::int64_t* out) {
  // Two rows share what is read of the feature.
  for (int r = 0; r < row_count; r += 2) {
    const std::int16_t* first = weights + std::int64_t{r} * stride;
    const std::int16_t* second = r + 1 < row_count ? first + stride : first;
    Sums a = {_mm256_setzero_si256(), _mm256_setzero_si256()}, b = a;
    for (int i = 0; i < stride; i += 16) {
      const __m256i f = sixteen(feature + i);
      add(a, _mm256_madd_epi16(f, sixteen(first + i)));
      add(b, _mm256_madd_epi16(f, sixteen(second + i)));
    }
    out[r] = total(a);
    if (r + 1 < row_count) out[r + 1] = total(b);
  }
}

}  // namespace im2fit
