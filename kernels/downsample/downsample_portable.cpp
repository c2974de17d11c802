// SPDX-License-Identifier: Apache-2.0
#include "kernels/downsample/downsample_block.h"

namespace im2fit::joints {

void downsample_box_portable(const DownsampleBox& box, std::uint16_t* out, DownsampleMoments& moments) {
  for_each_row(box, out, moments, [](const DownsampleRow&, int, std::uint16_t*, RowSums&) { return 0; });
}

void downsample_box(const DownsampleBox& box, std::uint16_t* out, DownsampleMoments& moments) {
  IM2FIT_CHOSEN_ONCE best = fastest(kDownsampleBoxKernels);
  best(box, out, moments);
}

}  // namespace im2fit::joints
