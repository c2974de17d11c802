// SPDX-License-Identifier: Apache-2.0
// Frames that differ by noise alone, as one: a person the device detects in half of them is in their median.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/camera.h"

namespace im2fit::lab {

// Pixel by pixel the median depth of frames of one size, the nearer of the two in the middle of an even number; no
// data counts as farthest. A pixel is then a near surface's when half of the frames have it there, as in DepthFusion.
// Not shareable between threads.
class MedianFrame {
 public:
  // At least one frame; out: no larger than they.
  void run(std::span<const DepthView> frames, DepthImage out);

 private:
  std::vector<std::uint16_t> rows_;  // one of each frame
};

// Of the median's mask those pixels where `frame` is within kOutlierMm of it: what fuses. Same sizes.
void mask_near(DepthView frame, DepthView median, MaskView mask, MaskImage out);

}  // namespace im2fit::lab
