// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/contour/contour.h"

namespace im2fit {
namespace {

struct Sums {
  uint32x4_t depth;
  uint64x2_t square;
};

struct Word {
  std::uint64_t seen, steps;
};

// Bit i of the result: byte i of the four vectors is 0xFF, not 0.
inline std::uint64_t bits(uint8x16_t a, uint8x16_t b, uint8x16_t c, uint8x16_t d) {
  const uint8x16_t place = {1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128};
  a = vandq_u8(a, place), b = vandq_u8(b, place), c = vandq_u8(c, place), d = vandq_u8(d, place);
#ifdef __aarch64__
  const uint8x16_t pairs = vpaddq_u8(vpaddq_u8(a, b), vpaddq_u8(c, d));
  return vgetq_lane_u64(vreinterpretq_u64_u8(vpaddq_u8(pairs, pairs)), 0);
#else
  const auto fold = [](uint8x16_t x, uint8x16_t y) {
    return vpadd_u8(vpadd_u8(vget_low_u8(x), vget_high_u8(x)), vpadd_u8(vget_low_u8(y), vget_high_u8(y)));
  };
  return vget_lane_u64(vreinterpret_u64_u8(vpadd_u8(fold(a, b), fold(c, d))), 0);
#endif
}

inline void add(Sums& s, uint16x8_t d) {
  s.depth = vpadalq_u16(s.depth, d);
  s.square = vpadalq_u32(s.square, vmull_u16(vget_low_u16(d), vget_low_u16(d)));
  s.square = vpadalq_u32(s.square, vmull_u16(vget_high_u16(d), vget_high_u16(d)));
}

// 64 pixels; `last` holds the masked depths of the 8 before them.
inline Word scan_word(const std::uint16_t* depth, const std::uint8_t* mask, uint16x8_t& last, Sums& sums) {
  uint8x16_t seen[4], steps[4];
  const uint16x8_t limit = vdupq_n_u16(kContourStepQ4);
  for (int i = 0; i < 4; ++i) {
    const uint8x16_t m = vld1q_u8(mask + 16 * i);
    const int8x16_t keep = vreinterpretq_s8_u8(vtstq_u8(m, m));
    const uint16x8_t a = vandq_u16(vld1q_u16(depth + 16 * i), vreinterpretq_u16_s16(vmovl_s8(vget_low_s8(keep))));
    const uint16x8_t b =
        vandq_u16(vld1q_u16(depth + 16 * i + 8), vreinterpretq_u16_s16(vmovl_s8(vget_high_s8(keep))));
    const uint16x8_t before_a = vextq_u16(last, a, 7), before_b = vextq_u16(a, b, 7);
    last = b;
    const uint16x8_t step_a = vandq_u16(vcgeq_u16(vabdq_u16(a, before_a), limit), vtstq_u16(before_a, before_a));
    const uint16x8_t step_b = vandq_u16(vcgeq_u16(vabdq_u16(b, before_b), limit), vtstq_u16(before_b, before_b));
    seen[i] = vcombine_u8(vmovn_u16(vtstq_u16(a, a)), vmovn_u16(vtstq_u16(b, b)));
    steps[i] = vcombine_u8(vmovn_u16(step_a), vmovn_u16(step_b));
    add(sums, a);
    add(sums, b);
  }
  Word word;
  word.seen = bits(seen[0], seen[1], seen[2], seen[3]);
  word.steps = bits(steps[0], steps[1], steps[2], steps[3]) & word.seen;
  return word;
}

inline bool empty(const std::uint8_t* mask) {
  const uint8x16_t any =
      vorrq_u8(vorrq_u8(vld1q_u8(mask), vld1q_u8(mask + 16)), vorrq_u8(vld1q_u8(mask + 32), vld1q_u8(mask + 48)));
  const uint8x8_t half = vorr_u8(vget_low_u8(any), vget_high_u8(any));
  return vget_lane_u64(vreinterpret_u64_u8(half), 0) == 0;
}

inline void copy16(std::uint8_t* to, const std::uint8_t* from) {
  vst1q_u8(to, vld1q_u8(from));
}
inline void copy16(std::uint16_t* to, const std::uint16_t* from) {
  vst1q_u16(to, vld1q_u16(from));
  vst1q_u16(to + 8, vld1q_u16(from + 8));
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
  Sums sums = {vdupq_n_u32(0), vdupq_n_u64(0)};
  uint16x8_t last = vdupq_n_u16(0);
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
      *seen = *steps = 0;
      last = vdupq_n_u16(0);
      continue;
    }
    const Word word = scan_word(d, m, last, sums);
    *seen = word.seen;
    *steps = word.steps;
    if (word.seen == 0) continue;
    any = true;
    if (row.last < 0) row.first = u + __builtin_ctzll(word.seen);
    row.last = u + 63 - __builtin_clzll(word.seen);
    row.count += static_cast<std::uint32_t>(__builtin_popcountll(word.seen));
  }
  if (any) {
    const uint64x2_t depth_pairs = vpaddlq_u32(sums.depth);
    row.depth_sum = static_cast<std::uint32_t>(vgetq_lane_u64(depth_pairs, 0) + vgetq_lane_u64(depth_pairs, 1));
    row.depth_square_sum = vgetq_lane_u64(sums.square, 0) + vgetq_lane_u64(sums.square, 1);
  }
  *out = row;
}

}  // namespace

void contour_neon(ImageView<const std::uint16_t> depth_q4, MaskView mask, ContourRow* rows, std::uint64_t* seen,
                  std::uint64_t* steps) {
  const std::ptrdiff_t words = (depth_q4.width + 63) / 64;
  for (std::ptrdiff_t v = 0; v < depth_q4.height; ++v) {
    scan_row(depth_q4.pixels + v * depth_q4.stride, mask.pixels + v * mask.stride, depth_q4.width, rows + v,
             seen + v * words, steps + v * words);
  }
}

}  // namespace im2fit
