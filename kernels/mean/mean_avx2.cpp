// SPDX-License-Identifier: Apache-2.0
// The quotient comes from a float division, within 0.02 of the true one (16 bits of quotient, three roundings of
// 2^-24), and is then put right by its remainder: exact.
#include <immintrin.h>

#include "kernels/mean/mean.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

__m256i quotient(__m256i a, __m256i n) {
  const __m256i q = _mm256_cvttps_epi32(_mm256_div_ps(_mm256_cvtepi32_ps(a), _mm256_cvtepi32_ps(n)));
  const __m256i rest = _mm256_sub_epi32(a, _mm256_mullo_epi32(q, n));
  const __m256i too_small = _mm256_cmpgt_epi32(rest, _mm256_sub_epi32(n, _mm256_set1_epi32(1)));
  const __m256i too_large = _mm256_cmpgt_epi32(_mm256_setzero_si256(), rest);
  return _mm256_add_epi32(_mm256_sub_epi32(q, too_small), too_large);
}

void eight(const std::uint32_t* sum, const std::uint16_t* seen, __m256i needed, std::uint16_t* depth_q4,
           std::uint8_t* mask) {
  const __m256i n = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(seen)));
  const __m256i few = _mm256_cmpgt_epi32(needed, n);
  __m256i q = _mm256_setzero_si256();
  if (_mm256_movemask_epi8(few) != -1) {
    const __m256i a = _mm256_slli_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(sum)), 4);
    q = _mm256_andnot_si256(few, quotient(_mm256_add_epi32(a, _mm256_srli_epi32(n, 1)), n));
  }
  _mm_storeu_si128(reinterpret_cast<__m128i*>(depth_q4),
                   _mm_packus_epi32(_mm256_castsi256_si128(q), _mm256_extracti128_si256(q, 1)));
  const __m128i words = _mm_packs_epi32(_mm256_castsi256_si128(few), _mm256_extracti128_si256(few, 1));
  const __m128i bytes = _mm_packs_epi16(words, words);
  _mm_storel_epi64(reinterpret_cast<__m128i*>(mask), _mm_xor_si128(bytes, _mm_set1_epi8(-1)));
}

}  // namespace

void mean_avx2(const std::uint32_t* sum, const std::uint16_t* seen, int count, int needed, std::uint16_t* depth_q4,
               std::uint8_t* mask) {
  const __m256i least = _mm256_set1_epi32(needed);
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) eight(sum + i, seen + i, least, depth_q4 + i, mask + i);
  mean_portable(sum + i, seen + i, count - i, needed, depth_q4 + i, mask + i);
}

}  // namespace im2fit
