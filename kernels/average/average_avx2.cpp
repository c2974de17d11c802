// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/average/average.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

// Eight pixels; `take` comes in as mask and depth's word on it. All values are below 2^31: signed comparisons do.
void eight(__m256i z, __m256i take, std::uint32_t* sum, std::uint16_t* seen) {
  const __m256i n = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(seen)));
  const __m256i so_far = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(sum));
  const __m256i away = _mm256_abs_epi32(_mm256_sub_epi32(_mm256_mullo_epi32(z, n), so_far));
  const __m256i outlier = _mm256_cmpgt_epi32(away, _mm256_mullo_epi32(n, _mm256_set1_epi32(kOutlierMm)));
  const __m256i add = _mm256_andnot_si256(outlier, take);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(sum), _mm256_add_epi32(so_far, _mm256_and_si256(z, add)));
  const __m256i counted = _mm256_sub_epi32(n, add);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(seen),
                   _mm_packus_epi32(_mm256_castsi256_si128(counted), _mm256_extracti128_si256(counted, 1)));
}

void eight_pixels(const std::uint16_t* depth, const std::uint8_t* mask, std::uint32_t* sum, std::uint16_t* seen) {
  const __m128i m = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(mask));
  if (_mm_testz_si128(m, m)) return;
  const __m256i z = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(depth)));
  const __m256i good = _mm256_andnot_si256(_mm256_cmpgt_epi32(z, _mm256_set1_epi32(kFusedDepthMaxMm)),
                                           _mm256_cmpgt_epi32(z, _mm256_setzero_si256()));
  eight(z, _mm256_and_si256(_mm256_cvtepi8_epi32(m), good), sum, seen);
}

}  // namespace

void average_avx2(const std::uint16_t* depth, const std::uint8_t* mask, int count, std::uint32_t* sum,
                  std::uint16_t* seen) {
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) eight_pixels(depth + i, mask + i, sum + i, seen + i);
  average_portable(depth + i, mask + i, count - i, sum + i, seen + i);
}

}  // namespace im2fit
