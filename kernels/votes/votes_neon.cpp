// SPDX-License-Identifier: Apache-2.0
// AArch64 only.
#if defined(__aarch64__)
#include <arm_neon.h>

#include "kernels/votes/votes.h"

namespace im2fit {
namespace {

constexpr int kLanes = 4;

struct Counts {
  uint32x4_t on = vdupq_n_u32(0), behind = vdupq_n_u32(0);
};

void four(const VotingPoints& p, int i, const float* q, Counts& counts) {
  const float32x4_t z = vld1q_f32(p.z_mm + i);
  const float32x4_t along =
      vaddq_f32(vmulq_n_f32(vld1q_f32(p.ray_x + i), q[0]), vmulq_n_f32(vld1q_f32(p.ray_y + i), q[1]));
  const float32x4_t inverse = vnegq_f32(vaddq_f32(along, vdupq_n_f32(q[2])));
  const float32x4_t plane = vdivq_f32(vdupq_n_f32(1.0F), inverse);
  const uint32x4_t meets = vcgtq_f32(inverse, vdupq_n_f32(1e-5F));
  const float32x4_t end = vaddq_f32(vaddq_f32(plane, vdupq_n_f32(80.0F)), vld1q_f32(p.far_mm + i));
  const uint32x4_t on = vcltq_f32(vabsq_f32(vsubq_f32(z, plane)), vld1q_f32(p.near_mm + i));
  counts.on = vsubq_u32(counts.on, vandq_u32(meets, on));
  counts.behind = vsubq_u32(counts.behind, vandq_u32(meets, vcgtq_f32(z, end)));
}

}  // namespace

void votes_neon(const VotingPoints& points, const float* q, Votes& out) {
  Counts counts;
  int i = 0;
  for (; i + kLanes <= points.count; i += kLanes) four(points, i, q, counts);
  out = {static_cast<int>(vaddvq_u32(counts.on)), static_cast<int>(vaddvq_u32(counts.behind))};
  if (i == points.count) return;
  const VotingPoints last = {points.ray_x + i,   points.ray_y + i,  points.z_mm + i,
                             points.near_mm + i, points.far_mm + i, points.count - i};
  Votes rest;
  votes_portable(last, q, rest);
  out.on += rest.on;
  out.behind += rest.behind;
}

}  // namespace im2fit
#endif
