// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/code_bounds/code_bounds.h"

namespace im2fit {
namespace {

inline int32x4_t add_gap(int32x4_t sum, int32x4_t low, int32x4_t high, int32x4_t place) {
  const int32x4_t gap = vmaxq_s32(vmaxq_s32(vsubq_s32(low, place), vsubq_s32(place, high)), vdupq_n_s32(0));
  const int32x4_t step = vminq_s32(vshrq_n_s32(gap, 4), vdupq_n_s32(kBoundGapMax));
  return vmlaq_s32(sum, step, step);
}

}  // namespace

void code_bounds_neon(const std::int32_t* blocks, int block_count, const std::int32_t* place, int dimension_count,
                      std::uint32_t* out) {
  for (int b = 0; b < block_count; ++b, out += kBoxBlock) {
    int32x4_t front = vdupq_n_s32(0), back = front;
    for (int d = 0; d < dimension_count; ++d, blocks += 2 * kBoxBlock) {
      const int32x4_t p = vdupq_n_s32(place[d]);
      front = add_gap(front, vld1q_s32(blocks), vld1q_s32(blocks + kBoxBlock), p);
      back = add_gap(back, vld1q_s32(blocks + 4), vld1q_s32(blocks + kBoxBlock + 4), p);
    }
    vst1q_u32(out, vreinterpretq_u32_s32(front));
    vst1q_u32(out + 4, vreinterpretq_u32_s32(back));
  }
}

}  // namespace im2fit
