// SPDX-License-Identifier: Apache-2.0
// A frame as OpenNI2 hands it over, checked and copied into millimetres.
#pragma once

#include <cstddef>

#include "core/camera.h"

namespace im2fit::hal {

struct RawFrame {
  const void* data = nullptr;
  std::size_t size_bytes = 0;
  int width = 0;  // of the part delivered: less than the picture when cropped
  int height = 0;
  int stride_bytes = 0;
  int crop_x = 0;
  int crop_y = 0;
  int unit_um = 1000;  // 1000 or 100
  bool mirrored = false;
};

// Fills all of `out` (pixels outside a crop become 0) as the camera sees it: a mirrored frame is turned back, 100 um
// are rounded to mm, 0.5 up. False, with `out` untouched, when the frame's sizes do not fit each other or `out`.
bool copy_raw_frame(const RawFrame& frame, DepthImage out);

}  // namespace im2fit::hal
