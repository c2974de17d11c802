// SPDX-License-Identifier: Apache-2.0
#include "kernels/anchors/one_anchor.h"

namespace im2fit::joints {

void anchor_depths_portable(const Anchor* anchors, int count, const AnchorJoints& joints, const AnchorBox& box,
                            std::int16_t* out, std::ptrdiff_t out_step) {
  for (int i = 0; i < count; ++i) out[i * out_step] = anchor_depth(anchors[i], joints, box);
}

void anchor_depths(const Anchor* anchors, int count, const AnchorJoints& joints, const AnchorBox& box,
                   std::int16_t* out, std::ptrdiff_t out_step) {
  IM2FIT_CHOSEN_ONCE best = fastest(kAnchorDepthsKernels);
  best(anchors, count, joints, box, out, out_step);
}

}  // namespace im2fit::joints
