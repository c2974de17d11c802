// SPDX-License-Identifier: Apache-2.0
// Sixteen cells at a time. Steps 4 and 2 are pictures of 640 and 320 pixels; others pick their samples one by one and
// share the median.
#include <immintrin.h>

#include "kernels/sample/sample.h"

namespace im2fit {
namespace {

constexpr int kLanes = 16;

__m256i load(const std::uint16_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}

__m256i sort_key(__m256i z) {
  const __m256i less = _mm256_sub_epi16(z, _mm256_set1_epi16(1));
  const __m256i far = _mm256_set1_epi16(kSampleDepthMaxMm);
  return _mm256_or_si256(less, _mm256_cmpeq_epi16(_mm256_max_epu16(less, far), less));
}

void order(__m256i& a, __m256i& b) {
  const __m256i low = _mm256_min_epu16(a, b);
  b = _mm256_max_epu16(a, b);
  a = low;
}

void median(__m256i a, __m256i b, __m256i c, __m256i d, __m256i e, std::uint16_t* out) {
  a = sort_key(a);
  b = sort_key(b);
  c = sort_key(c);
  d = sort_key(d);
  e = sort_key(e);
  order(a, b);
  order(d, e);
  order(c, e);
  order(c, d);
  order(a, d);
  order(a, c);
  order(b, e);
  order(b, d);
  order(b, c);
  const __m256i none = _mm256_set1_epi16(-1);
  const __m256i fewer = _mm256_blendv_epi8(b, a, _mm256_cmpeq_epi16(c, none));
  const __m256i chosen = _mm256_blendv_epi8(c, fewer, _mm256_cmpeq_epi16(e, none));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_add_epi16(chosen, _mm256_set1_epi16(1)));
}

// 64 pixels to the first, third and fourth of every four. Each 32-bit word is cut to one of its pixels, then two
// rounds of packing bring them together; packing works on half registers, which the permutation puts right.
__m256i gather_words(__m256i a, __m256i b, __m256i c, __m256i d) {
  const __m256i even = _mm256_set1_epi64x(0xFFFF);
  const __m256i ab = _mm256_packus_epi32(_mm256_and_si256(a, even), _mm256_and_si256(b, even));
  const __m256i cd = _mm256_packus_epi32(_mm256_and_si256(c, even), _mm256_and_si256(d, even));
  const __m256i all = _mm256_packus_epi32(ab, cd);
  return _mm256_permutevar8x32_epi32(all, _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7));
}
template <int kShift>
__m256i every_fourth(const __m256i* p) {
  return gather_words(_mm256_srli_epi64(p[0], kShift), _mm256_srli_epi64(p[1], kShift),
                      _mm256_srli_epi64(p[2], kShift), _mm256_srli_epi64(p[3], kShift));
}
// 32 pixels to the even and the odd ones.
__m256i every_second(__m256i a, __m256i b) {
  return _mm256_permute4x64_epi64(_mm256_packus_epi32(a, b), 0xD8);
}
__m256i even(__m256i a, __m256i b) {
  const __m256i low = _mm256_set1_epi32(0xFFFF);
  return every_second(_mm256_and_si256(a, low), _mm256_and_si256(b, low));
}
__m256i odd(__m256i a, __m256i b) {
  return every_second(_mm256_srli_epi32(a, 16), _mm256_srli_epi32(b, 16));
}

struct Rows {
  const std::uint16_t *top, *middle, *bottom;  // of a row of cells
};

void cells_of_4(const Rows& p, std::uint16_t* out) {
  const __m256i t[4] = {load(p.top), load(p.top + 16), load(p.top + 32), load(p.top + 48)};
  const __m256i m[4] = {load(p.middle), load(p.middle + 16), load(p.middle + 32), load(p.middle + 48)};
  const __m256i b[4] = {load(p.bottom), load(p.bottom + 16), load(p.bottom + 32), load(p.bottom + 48)};
  median(every_fourth<0>(t), every_fourth<48>(t), every_fourth<32>(m), every_fourth<0>(b), every_fourth<48>(b), out);
}

void cells_of_2(const Rows& p, std::uint16_t* out) {
  const __m256i t0 = load(p.top), t1 = load(p.top + 16), b0 = load(p.bottom), b1 = load(p.bottom + 16);
  const __m256i low = odd(b0, b1);  // also the middle one
  median(even(t0, t1), odd(t0, t1), low, even(b0, b1), low, out);
}

// Any step, and the remainder of a row: `count` cells from 1 to 16.
void cells_one_by_one(const Rows& p, int step, int count, std::uint16_t* out) {
  alignas(32) std::uint16_t samples[5][kLanes] = {};
  for (int c = 0; c < count; ++c) {
    const int u = c * step;
    samples[0][c] = p.top[u];
    samples[1][c] = p.top[u + step - 1];
    samples[2][c] = p.middle[u + step / 2];
    samples[3][c] = p.bottom[u];
    samples[4][c] = p.bottom[u + step - 1];
  }
  alignas(32) std::uint16_t medians[kLanes];
  median(load(samples[0]), load(samples[1]), load(samples[2]), load(samples[3]), load(samples[4]), medians);
  for (int c = 0; c < count; ++c) out[c] = medians[c];
}

}  // namespace

void sample_avx2(DepthView depth, int step, std::uint16_t* out) {
  const int width = depth.width / step;
  const std::ptrdiff_t stride = depth.stride;
  for (int r = 0; r < depth.height / step; ++r) {
    const std::uint16_t* top = depth.pixels + r * step * stride;
    const Rows row = {top, top + (step / 2) * stride, top + (step - 1) * stride};
    for (int c = 0; c < width; c += kLanes) {
      const Rows here = {row.top + c * step, row.middle + c * step, row.bottom + c * step};
      const int left = width - c;
      if (left < kLanes || (step != 4 && step != 2))
        cells_one_by_one(here, step, left < kLanes ? left : kLanes, out + c);
      else if (step == 4)
        cells_of_4(here, out + c);
      else
        cells_of_2(here, out + c);
    }
    out += width;
  }
  // GCC 12 forgets this after a call of median(). With the upper parts in use, all SSE code that follows waits for
  // registers it does not need: the search for the floor took two and a half times as long.
  _mm256_zeroupper();
}

}  // namespace im2fit
