// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::joints {

void anchor_depths_ref(const Anchor* anchors, int count, const AnchorJoints& joints, const AnchorBox& box,
                       std::int16_t* out, std::ptrdiff_t out_step) {
  for (int i = 0; i < count; ++i) {
    const Anchor& a = anchors[i];
    const float share = static_cast<float>(a.share_q8) / 256.0F;
    const auto between = [&](const float* of) { return of[a.joint] + (of[a.towards] - of[a.joint]) * share; };
    const float scale = between(joints.inverse_z);
    const float ray_x = (between(joints.x) + static_cast<float>(a.dx)) * scale;
    const float ray_y = (between(joints.y) + static_cast<float>(a.dy)) * scale;
    // Rounded at 8192, where a float's last place is 1/1024 px: to the nearest pixel but for that.
    const int u = static_cast<int>(std::floor(box.fx * ray_x + box.cx + 8192.5F)) - 8192 - box.u_first;
    const int v = static_cast<int>(std::floor(box.fy * ray_y + box.cy + 8192.5F)) - 8192 - box.v_first;
    out[i * out_step] = kAnchorFarMm;
    if (u < 0 || v < 0 || u >= box.width || v >= box.height) continue;
    const int depth = box.depth[static_cast<std::ptrdiff_t>(v) * box.width + u];
    if (depth != 0)
      out[i * out_step] =
          static_cast<std::int16_t>(std::clamp(depth - box.reference_mm, -kAnchorFarMm, kAnchorFarMm));
  }
}

}  // namespace im2fit::joints
