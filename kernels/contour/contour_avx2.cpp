// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/contour/contour.h"

namespace im2fit {
namespace {

struct Sums {
  // Depths as 256 h + l: products of bytes in pairs stay below 2^17, so 32 bits hold a row of 2^18 pixels.
  __m256i low, high;  // of l, of h
  __m256i low_low, low_high, high_high;
};

struct Word {
  std::uint64_t seen, steps;
};

// Bits of 32 pixels whose 16-bit lanes are not zero.
inline std::uint32_t nonzero_bits(__m256i a, __m256i b) {
  const __m256i zero = _mm256_setzero_si256();
  const __m256i is_zero = _mm256_packs_epi16(_mm256_cmpeq_epi16(a, zero), _mm256_cmpeq_epi16(b, zero));
  return ~static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_permute4x64_epi64(is_zero, 0xD8)));
}

inline __m256i masked_depths(const std::uint16_t* depth, const std::uint8_t* mask) {
  const __m256i d = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(depth));
  const __m256i m = _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(mask)));
  return _mm256_and_si256(d, _mm256_cmpgt_epi16(m, _mm256_setzero_si256()));
}

inline __m256i step_excess(__m256i here, __m256i before) {
  const __m256i rise = _mm256_or_si256(_mm256_subs_epu16(here, before), _mm256_subs_epu16(before, here));
  return _mm256_subs_epu16(rise, _mm256_set1_epi16(kContourStepQ4 - 1));
}

inline void add(Sums& s, __m256i d) {
  const __m256i zero = _mm256_setzero_si256();
  const __m256i low = _mm256_and_si256(d, _mm256_set1_epi16(0xFF)), high = _mm256_srli_epi16(d, 8);
  s.low = _mm256_add_epi64(s.low, _mm256_sad_epu8(low, zero));
  s.high = _mm256_add_epi64(s.high, _mm256_sad_epu8(high, zero));
  s.low_low = _mm256_add_epi32(s.low_low, _mm256_madd_epi16(low, low));
  s.low_high = _mm256_add_epi32(s.low_high, _mm256_madd_epi16(low, high));
  s.high_high = _mm256_add_epi32(s.high_high, _mm256_madd_epi16(high, high));
}

inline std::uint64_t sum64(__m256i a) {
  const __m128i half = _mm_add_epi64(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
  return static_cast<std::uint64_t>(_mm_cvtsi128_si64(half)) + static_cast<std::uint64_t>(_mm_extract_epi64(half, 1));
}
inline std::uint64_t sum32(__m256i a) {
  const __m256i even = _mm256_and_si256(a, _mm256_set1_epi64x(0xFFFFFFFF));
  return sum64(_mm256_add_epi64(even, _mm256_srli_epi64(a, 32)));
}

// 64 pixels; `last` holds the masked depths of the 16 before them.
inline Word scan_word(const std::uint16_t* depth, const std::uint8_t* mask, __m256i& last, std::uint64_t before_seen,
                      Sums& sums) {
  Word word = {0, 0};
  for (int half = 0; half < 2; ++half) {
    const __m256i a = masked_depths(depth + 32 * half, mask + 32 * half);
    const __m256i b = masked_depths(depth + 32 * half + 16, mask + 32 * half + 16);
    const __m256i before_a = _mm256_alignr_epi8(a, _mm256_permute2x128_si256(last, a, 0x21), 14);
    const __m256i before_b = _mm256_alignr_epi8(b, _mm256_permute2x128_si256(a, b, 0x21), 14);
    last = b;
    word.seen |= std::uint64_t{nonzero_bits(a, b)} << (32 * half);
    word.steps |= std::uint64_t{nonzero_bits(step_excess(a, before_a), step_excess(b, before_b))} << (32 * half);
    add(sums, a);
    add(sums, b);
  }
  word.steps &= word.seen & (word.seen << 1 | before_seen);
  return word;
}

inline bool empty(const std::uint8_t* mask) {
  const __m256i a = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(mask));
  const __m256i b = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(mask + 32));
  const __m256i any = _mm256_or_si256(a, b);
  return _mm256_testz_si256(any, any) != 0;
}

inline void copy16(std::uint8_t* to, const std::uint8_t* from) {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
}
inline void copy16(std::uint16_t* to, const std::uint16_t* from) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
}
// `count` values, fewer than 64, then zeros.
template <class T>
inline void copy_tail(T* to, const T* from, int count) {
  const T zeros[16] = {};
  for (int i = 0; i < 64; i += 16) {
    if (i + 16 <= count) {
      copy16(to + i, from + i);
    } else {
      copy16(to + i, zeros);
      for (int n = i; n < count; ++n) to[n] = from[n];
    }
  }
}

void scan_row(const std::uint16_t* depth, const std::uint8_t* mask, int width, ContourRow* out, std::uint64_t* seen,
              std::uint64_t* steps) {
  const __m256i zero = _mm256_setzero_si256();
  Sums sums = {zero, zero, zero, zero, zero};
  __m256i last = zero;
  std::uint64_t before_seen = 0;
  ContourRow row = {width, -1, 0, 0, 0};
  bool any = false;
  for (int u = 0; u < width; u += 64, ++seen, ++steps) {
    const std::uint16_t* d = depth + u;
    const std::uint8_t* m = mask + u;
    std::uint16_t depth_tail[64];
    std::uint8_t mask_tail[64];
    if (width - u < 64) {
      copy_tail(mask_tail, m, width - u);
      m = mask_tail;
      if (!empty(m)) copy_tail(depth_tail, d, width - u);
      d = depth_tail;
    }
    if (empty(m)) {
      *seen = *steps = before_seen = 0;
      continue;
    }
    const Word word = scan_word(d, m, last, before_seen, sums);
    before_seen = word.seen >> 63;
    *seen = word.seen;
    *steps = word.steps;
    if (word.seen == 0) continue;
    any = true;
    if (row.last < 0) row.first = u + __builtin_ctzll(word.seen);
    row.last = u + 63 - __builtin_clzll(word.seen);
    row.count += static_cast<std::uint32_t>(__builtin_popcountll(word.seen));
  }
  if (any) {
    row.depth_sum = static_cast<std::uint32_t>(sum64(sums.low) + 256 * sum64(sums.high));
    row.depth_square_sum = sum32(sums.low_low) + 512 * sum32(sums.low_high) + 65536 * sum32(sums.high_high);
  }
  *out = row;
}

}  // namespace

void contour_avx2(ImageView<const std::uint16_t> depth_q4, MaskView mask, ContourRow* rows, std::uint64_t* seen,
                  std::uint64_t* steps) {
  const std::ptrdiff_t words = (depth_q4.width + 63) / 64;
  for (std::ptrdiff_t v = 0; v < depth_q4.height; ++v) {
    scan_row(depth_q4.pixels + v * depth_q4.stride, mask.pixels + v * mask.stride, depth_q4.width, rows + v,
             seen + v * words, steps + v * words);
  }
}

}  // namespace im2fit
