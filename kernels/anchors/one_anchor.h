// SPDX-License-Identifier: Apache-2.0
// One anchor, without branches: half of the places lie beside the person. Included by each tier into its own
// translation unit.
#pragma once

#include <cstddef>

#include "kernels/anchors/anchors.h"

namespace im2fit::joints {
namespace {

// The offset keeps the truncation a floor for rays left of and above the picture.
constexpr float kFloorShift = 8192.5F;
constexpr int kFloorUnshift = 8192;

inline std::int16_t anchor_depth(const Anchor& a, const AnchorJoints& joints, const AnchorBox& box) {
  const float share = static_cast<float>(a.share_q8) * (1.0F / 256.0F);
  const float x = joints.x[a.joint] + (joints.x[a.towards] - joints.x[a.joint]) * share;
  const float y = joints.y[a.joint] + (joints.y[a.towards] - joints.y[a.joint]) * share;
  const float scale = joints.inverse_z[a.joint] + (joints.inverse_z[a.towards] - joints.inverse_z[a.joint]) * share;
  const float rx = (x + static_cast<float>(a.dx)) * scale, ry = (y + static_cast<float>(a.dy)) * scale;
  const int u = static_cast<int>(box.fx * rx + box.cx + kFloorShift) - kFloorUnshift - box.u_first;
  const int v = static_cast<int>(box.fy * ry + box.cy + kFloorShift) - kFloorUnshift - box.v_first;
  const bool inside = (static_cast<unsigned>(u) < static_cast<unsigned>(box.width)) &
                      (static_cast<unsigned>(v) < static_cast<unsigned>(box.height));
  const int d = box.depth[inside ? static_cast<std::ptrdiff_t>(v) * box.width + u : 0];
  const int away = d - box.reference_mm;
  const int near = away > kAnchorFarMm ? kAnchorFarMm : (away < -kAnchorFarMm ? -kAnchorFarMm : away);
  return static_cast<std::int16_t>((inside & (d != 0)) ? near : kAnchorFarMm);
}

}  // namespace
}  // namespace im2fit::joints
