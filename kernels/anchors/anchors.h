// SPDX-License-Identifier: Apache-2.0
// Shape-indexed pixels: the depth under places that hang on the joints.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/joints.h"
#include "kernels/tier.h"

namespace im2fit::joints {

// One shape-indexed pixel: a place on the line from one joint to another, and an offset from there, mm. Between
// joints of a limb it follows the limb whatever way that points (Burgos-Artizzu et al. 2013, section 3.1).
struct Anchor {
  std::int16_t dx = 0;
  std::int16_t dy = 0;
  std::uint8_t joint = 0;
  std::uint8_t towards = 0;
  std::int16_t share_q8 = 0;  // 0 at `joint`, 256 at `towards`
};
static_assert(sizeof(Anchor) == 8);

inline constexpr int kAnchorLanes = 16;  // joints, and unused places
static_assert(kJointCount <= kAnchorLanes);
struct AnchorJoints {
  alignas(32) float x[kAnchorLanes] = {}, y[kAnchorLanes] = {};  // mm
  alignas(32) float inverse_z[kAnchorLanes] = {};                // 1/mm
};
// A box of the picture: its pixel (0, 0) is the picture's (u_first, v_first).
struct AnchorBox {
  const std::uint16_t* depth;  // mm, 0: no person; width * height >= 1 values
  int width, height, u_first, v_first;
  float fx, fy, cx, cy;
  int reference_mm;
};
inline constexpr int kAnchorFarMm = 600;

// out[i * out_step]: depth under anchor i less the reference, within +-kAnchorFarMm; kAnchorFarMm without a person.
// The place is p = from + (to - from) share + (dx, dy) over 1/z interpolated likewise. Joints of all anchors <
// kAnchorLanes; places within 10^7 px. No allocation, thread-safe. Every product and sum is rounded once: all tiers
// agree bit for bit.
using AnchorDepthsFunction = void(const Anchor* anchors, int count, const AnchorJoints& joints, const AnchorBox& box,
                                  std::int16_t* out, std::ptrdiff_t out_step);
AnchorDepthsFunction anchor_depths_portable, anchor_depths_neon, anchor_depths_avx2, anchor_depths;

inline constexpr KernelVariant<AnchorDepthsFunction> kAnchorDepthsKernels[] = {
    IM2FIT_PORTABLE(anchor_depths) IM2FIT_NEON(anchor_depths) IM2FIT_AVX2(anchor_depths)};

}  // namespace im2fit::joints
