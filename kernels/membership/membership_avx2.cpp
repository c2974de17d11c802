// SPDX-License-Identifier: Apache-2.0
// A cell of 4 x 4 pixels is one register. Cells of other sizes, those at the picture's right and lower end among
// them, are copied to such blocks and back.
#include <immintrin.h>

#include "kernels/membership/membership.h"

namespace im2fit {
namespace {

constexpr int kLanes = 16;

__m256i distance(__m256i a, __m256i b) {
  return _mm256_or_si256(_mm256_subs_epu16(a, b), _mm256_subs_epu16(b, a));
}
__m256i at_most(__m256i a, __m256i b) {
  return _mm256_cmpeq_epi16(_mm256_min_epu16(a, b), a);
}

// floor(40 + 1.5 (2.85e-6 z z)): a whole distance is above the limit when it is above this.
__m256i limit_half(__m256i z) {
  const __m256 f = _mm256_cvtepi32_ps(z);
  const __m256 quantum = _mm256_mul_ps(_mm256_mul_ps(_mm256_set1_ps(2.85e-6F), f), f);
  return _mm256_cvttps_epi32(_mm256_add_ps(_mm256_set1_ps(40.0F), _mm256_mul_ps(_mm256_set1_ps(1.5F), quantum)));
}
__m256i limit(__m256i z) {
  const __m256i zero = _mm256_setzero_si256();
  return _mm256_packus_epi32(limit_half(_mm256_unpacklo_epi16(z, zero)), limit_half(_mm256_unpackhi_epi16(z, zero)));
}

// The cells around one, read once for all its pixels.
struct Around {
  __m256i person[9], other[9], own;
  int person_count = 0, other_count = 0;
  bool interior = false;
};

void look_around(const MembershipCells& cells, int c, int r, Around& out) {
  const std::ptrdiff_t middle = std::ptrdiff_t{r} * cells.stride + c;
  out.person_count = out.other_count = 0;
  for (int k = 0; k < 9; ++k) {
    const std::ptrdiff_t at = middle + (k / 3 - 1) * std::ptrdiff_t{cells.stride} + k % 3 - 1;
    const std::uint16_t p = cells.person[at], o = cells.other[at];
    if (p != kNoSurface) out.person[out.person_count++] = _mm256_set1_epi16(static_cast<short>(p));
    if (o != kNoSurface) out.other[out.other_count++] = _mm256_set1_epi16(static_cast<short>(o));
  }
  out.own = _mm256_set1_epi16(static_cast<short>(cells.person[middle]));
  out.interior = out.other_count == 0 && cells.person[middle] != kNoSurface;
}

// -1 in the lanes that belong.
__m256i judge(const Around& around, __m256i z) {
  const __m256i less = _mm256_sub_epi16(z, _mm256_set1_epi16(1));
  const __m256i seen = at_most(less, _mm256_set1_epi16(9999));
  __m256i inside = _mm256_setzero_si256();
  if (around.interior) {
    inside = at_most(distance(z, around.own), _mm256_set1_epi16(39));
    if (_mm256_testc_si256(inside, seen)) return seen;
  }
  __m256i person = _mm256_set1_epi16(-1), other = person;
  for (int i = 0; i < around.person_count; ++i) person = _mm256_min_epu16(person, distance(z, around.person[i]));
  for (int i = 0; i < around.other_count; ++i) other = _mm256_min_epu16(other, distance(z, around.other[i]));
  const __m256i near = _mm256_and_si256(at_most(person, limit(z)), at_most(person, other));
  return _mm256_and_si256(seen, _mm256_or_si256(inside, near));
}

void cell_of_4(const Around& around, const std::uint16_t* z, std::ptrdiff_t z_stride, std::uint8_t* out,
               std::ptrdiff_t out_stride) {
  const auto row = [&](int v) { return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(z + v * z_stride)); };
  const __m128i upper = _mm_unpacklo_epi64(row(0), row(1)), lower = _mm_unpacklo_epi64(row(2), row(3));
  const __m256i belongs = judge(around, _mm256_inserti128_si256(_mm256_castsi128_si256(upper), lower, 1));
  const __m128i bytes = _mm_packs_epi16(_mm256_castsi256_si128(belongs), _mm256_extracti128_si256(belongs, 1));
  _mm_storeu_si32(out, bytes);
  _mm_storeu_si32(out + out_stride, _mm_srli_si128(bytes, 4));
  _mm_storeu_si32(out + 2 * out_stride, _mm_srli_si128(bytes, 8));
  _mm_storeu_si32(out + 3 * out_stride, _mm_srli_si128(bytes, 12));
}

void row_of_any(const Around& around, const std::uint16_t* z, int count, std::uint8_t* out) {
  for (int first = 0; first < count; first += kLanes) {
    const int n = count - first < kLanes ? count - first : kLanes;
    alignas(32) std::uint16_t block[kLanes] = {};
    for (int i = 0; i < n; ++i) block[i] = z[first + i];
    __m256i* lanes = reinterpret_cast<__m256i*>(block);
    _mm256_store_si256(lanes, judge(around, _mm256_load_si256(lanes)));
    for (int i = 0; i < n; ++i) out[first + i] = static_cast<std::uint8_t>(block[i]);
  }
}

}  // namespace

void membership_avx2(DepthView depth, const MembershipCells& cells, const std::uint32_t* list, int count,
                     MaskImage mask) {
  Around around;
  for (int i = 0; i < count; ++i) {
    const int c = static_cast<int>(list[i] & 0xFFFF), r = static_cast<int>(list[i] >> 16);
    look_around(cells, c, r, around);
    const int u = c * cells.step, v = r * cells.step;
    const int wide = c + 1 == cells.width ? mask.width - u : cells.step;
    const int high = r + 1 == cells.height ? mask.height - v : cells.step;
    const std::uint16_t* z = depth.pixels + std::ptrdiff_t{v} * depth.stride + u;
    std::uint8_t* out = mask.pixels + std::ptrdiff_t{v} * mask.stride + u;
    if (wide == 4 && high == 4) {
      cell_of_4(around, z, depth.stride, out, mask.stride);
    } else {
      for (int row = 0; row < high; ++row)
        row_of_any(around, z + std::ptrdiff_t{row} * depth.stride, wide, out + std::ptrdiff_t{row} * mask.stride);
    }
  }
}

}  // namespace im2fit
