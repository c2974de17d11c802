// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/downsample/downsample_block.h"

namespace im2fit::joints {
namespace {

// Sixteen depths, zero where the mask is.
inline __m256i masked(const std::uint16_t* depth, const std::uint8_t* mask) {
  const __m128i off = _mm_cmpeq_epi8(_mm_loadu_si128(reinterpret_cast<const __m128i*>(mask)), _mm_setzero_si128());
  return _mm256_andnot_si256(_mm256_cvtepi8_epi16(off), _mm256_loadu_si256(reinterpret_cast<const __m256i*>(depth)));
}
// a where it is not 0, else b; lanes of 32 bits.
inline __m256i first_of(__m256i a, __m256i b) {
  return _mm256_or_si256(a, _mm256_and_si256(_mm256_cmpeq_epi32(a, _mm256_setzero_si256()), b));
}
// Eight blocks of two columns, as 32-bit values.
inline __m256i first_of_pair(__m256i v) {
  return first_of(_mm256_and_si256(v, _mm256_set1_epi32(0xFFFF)), _mm256_srli_epi32(v, 16));
}
inline __m256i eight_of_two(const DownsampleRow& r, int u) {
  const std::uint16_t* depth = r.depth + std::ptrdiff_t{2} * u;
  const std::uint8_t* mask = r.mask + std::ptrdiff_t{2} * u;
  const __m256i upper = first_of_pair(masked(depth, mask));
  const __m256i lower = first_of_pair(masked(depth + r.depth_stride, mask + r.mask_stride));
  return first_of(upper, lower);
}
inline __m256i eight_of_one(const DownsampleRow& r, int u) {
  const __m128i off =
      _mm_cmpeq_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(r.mask + u)), _mm_setzero_si128());
  const __m128i depth = _mm_loadu_si128(reinterpret_cast<const __m128i*>(r.depth + u));
  return _mm256_cvtepu16_epi32(_mm_andnot_si128(_mm_cvtepi8_epi16(off), depth));
}

template <class Eight>
inline int whole_row(const DownsampleRow& row, int count, std::uint16_t* out, RowSums& sums, Eight eight) {
  __m256i once = _mm256_setzero_si256(), again = once, empty = once;
  int u = 0;
  for (; u + 8 <= count; u += 8) {
    const __m256i z = eight(row, u);
    const __m128i narrow = _mm_packus_epi32(_mm256_castsi256_si128(z), _mm256_extracti128_si256(z, 1));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + u), narrow);
    once = _mm256_add_epi32(once, z);
    again = _mm256_add_epi32(again, once);
    empty = _mm256_sub_epi32(empty, _mm256_cmpeq_epi32(z, _mm256_setzero_si256()));
  }
  alignas(32) std::uint32_t o[8], a[8], e[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(o), once);
  _mm256_store_si256(reinterpret_cast<__m256i*>(a), again);
  _mm256_store_si256(reinterpret_cast<__m256i*>(e), empty);
  sums.count += static_cast<std::uint32_t>(u);
  for (int l = 0; l < 8; ++l) sums.count -= e[l];
  add_lanes(o, a, 8, u / 8, sums);
  return u;
}

}  // namespace

void downsample_box_avx2(const DownsampleBox& box, std::uint16_t* out, DownsampleMoments& moments) {
  const int step = box.step;
  for_each_row(box, out, moments, [step](const DownsampleRow& row, int count, std::uint16_t* to, RowSums& sums) {
    if (step == 2) return whole_row(row, count, to, sums, eight_of_two);
    if (step == 1) return whole_row(row, count, to, sums, eight_of_one);
    return 0;
  });
}

}  // namespace im2fit::joints
