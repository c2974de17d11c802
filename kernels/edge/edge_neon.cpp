// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/edge/edge_border.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

struct Answer {
  uint16x8_t far, near;  // all ones where a neighbour was
};

uint16x8_t high_half(uint16x8_t a, uint16x8_t b) {
  return vcombine_u16(vshrn_n_u32(vmull_u16(vget_low_u16(a), vget_low_u16(b)), 16),
                      vshrn_n_u32(vmull_u16(vget_high_u16(a), vget_high_u16(b)), 16));
}

void look(uint16x8_t z, uint16x8_t limit, const std::uint16_t* p, bool straight, Answer& answer) {
  const uint16x8_t other = vld1q_u16(p);
  const uint16x8_t there = vtstq_u16(other, other);
  const uint16x8_t within = vcleq_u16(vabdq_u16(z, other), limit);
  answer.near = vorrq_u16(answer.near, vandq_u16(there, within));
  if (straight) answer.far = vorrq_u16(answer.far, vbicq_u16(there, within));
}

// All ones where an edge is.
uint16x8_t eight(const std::uint16_t* p, std::ptrdiff_t stride) {
  const uint16x8_t z = vld1q_u16(p);
  const uint16x8_t limit = vaddq_u16(high_half(high_half(z, z), vdupq_n_u16(18361)), vdupq_n_u16(40));
  Answer answer = {vdupq_n_u16(0), vdupq_n_u16(0)};
  look(z, limit, p - stride, true, answer);
  look(z, limit, p + stride, true, answer);
  look(z, limit, p - 1, true, answer);
  look(z, limit, p + 1, true, answer);
  look(z, limit, p - stride - 1, false, answer);
  look(z, limit, p - stride + 1, false, answer);
  look(z, limit, p + stride - 1, false, answer);
  look(z, limit, p + stride + 1, false, answer);
  return vandq_u16(vtstq_u16(z, z), vornq_u16(answer.far, answer.near));
}

}  // namespace

void edge_neon(DepthView depth, MaskImage mask) {
  for (int v = 0; v < depth.height; ++v) {
    const std::uint16_t* in = depth.pixels + std::ptrdiff_t{v} * depth.stride;
    std::uint8_t* out = mask.pixels + std::ptrdiff_t{v} * mask.stride;
    int u = 0;
    if (v > 0 && v + 1 < depth.height && depth.width >= kLanes + 2) {
      edge_pixels(depth, mask, v, 0, 1);
      for (u = 1; u + kLanes + 1 <= depth.width; u += kLanes)
        vst1_u8(out + u, vmovn_u16(eight(in + u, depth.stride)));
    }
    edge_pixels(depth, mask, v, u, depth.width);
  }
}

}  // namespace im2fit
