// SPDX-License-Identifier: Apache-2.0
#include "kernels/thin/thin_block.h"

namespace im2fit::joints {

void thin_box_portable(const ThinBox& box, std::uint16_t* out, ThinMoments& moments) {
  for_each_row(box, out, moments, [](const ThinRow&, int, std::uint16_t*, RowSums&) { return 0; });
}

void thin_box(const ThinBox& box, std::uint16_t* out, ThinMoments& moments) {
  IM2FIT_CHOSEN_ONCE best = fastest(kThinBoxKernels);
  best(box, out, moments);
}

}  // namespace im2fit::joints
