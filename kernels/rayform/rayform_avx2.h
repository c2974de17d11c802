// SPDX-License-Identifier: Apache-2.0
// Eight pixels' coordinates along an axis. For *_avx2.cpp only.
#pragma once

#include <immintrin.h>

#include <cstdint>

namespace im2fit {
namespace {

// Eight depths in both layouts the 64-bit products need.
struct FormDepth8 {
  __m256i even, odd;  // FormDepth raws; the odd lanes moved to even places
};

inline FormDepth8 form_depth8(__m256i depth_q4) {
  const __m256i depth = _mm256_slli_epi32(depth_q4, 9);  // kFormDepthShift
  return {depth, _mm256_srli_epi64(depth, 32)};
}

// Rounding doubling high multiply: (a b + 2^30) >> 31, lane by lane. Bits 31..62 of the odd products lie in the upper
// half after a shift by one.
inline __m256i form_product8(__m256i slope, const FormDepth8& depth) {
  const __m256i half = _mm256_set1_epi64x(std::int64_t{1} << 30);
  const __m256i even = _mm256_add_epi64(_mm256_mul_epi32(slope, depth.even), half);
  const __m256i odd = _mm256_add_epi64(_mm256_mul_epi32(_mm256_srli_epi64(slope, 32), depth.odd), half);
  return _mm256_blend_epi32(_mm256_srli_epi64(even, 31), _mm256_slli_epi64(odd, 1), 0xAA);
}

inline __m256i form_slope8(const std::int32_t* columns, __m256i row) {
  return _mm256_add_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(columns)), row);
}

inline bool masked8(const std::uint8_t* mask) {
  return _mm_cvtsi128_si64(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(mask))) != 0;
}

// Depths of eight pixels as 32 bits, 0 where they are not seen.
inline __m256i seen_depth8(const std::uint16_t* depth, const std::uint8_t* mask) {
  const __m256i d = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(depth)));
  const __m256i m = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(mask)));
  return _mm256_and_si256(d, _mm256_cmpgt_epi32(m, _mm256_setzero_si256()));
}

inline int lane_bits8(__m256i a) {
  return _mm256_movemask_ps(_mm256_castsi256_ps(a));
}

}  // namespace
}  // namespace im2fit
