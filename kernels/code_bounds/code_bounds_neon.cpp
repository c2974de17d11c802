// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include <cstddef>

#include "kernels/code_bounds/code_bounds.h"

namespace im2fit {
namespace {

// The way from the place to the nearest value between the edges.
inline int32x4_t add_gap(int32x4_t sum, const std::int32_t* box, int32x4_t place) {
  const int32x4_t nearest = vminq_s32(vmaxq_s32(place, vld1q_s32(box)), vld1q_s32(box + kBoxBlock));
  const int32x4_t step = vminq_s32(vshrq_n_s32(vabdq_s32(place, nearest), 4), vdupq_n_s32(kBoundGapMax));
  return vmlaq_s32(sum, step, step);
}

}  // namespace

void code_bounds_neon(const std::int32_t* blocks, int block_count, const std::int32_t* place, int dimension_count,
                      std::uint32_t* out) {
  const std::ptrdiff_t size = std::ptrdiff_t{dimension_count} * 2 * kBoxBlock;
  // Two blocks at a time; an odd last one is done twice.
  for (int b = 0; b < block_count; b += 2) {
    const std::int32_t *first = blocks + b * size, *second = b + 1 < block_count ? first + size : first;
    int32x4_t s0 = vdupq_n_s32(0), s1 = s0, s2 = s0, s3 = s0;
    for (int d = 0; d < dimension_count; ++d, first += 2 * kBoxBlock, second += 2 * kBoxBlock) {
      const int32x4_t p = vdupq_n_s32(place[d]);
      s0 = add_gap(s0, first, p);
      s1 = add_gap(s1, first + 4, p);
      s2 = add_gap(s2, second, p);
      s3 = add_gap(s3, second + 4, p);
    }
    std::uint32_t *front = out + b * kBoxBlock, *back = b + 1 < block_count ? front + kBoxBlock : front;
    vst1q_u32(front, vreinterpretq_u32_s32(s0));
    vst1q_u32(front + 4, vreinterpretq_u32_s32(s1));
    vst1q_u32(back, vreinterpretq_u32_s32(s2));
    vst1q_u32(back + 4, vreinterpretq_u32_s32(s3));
  }
}

}  // namespace im2fit
