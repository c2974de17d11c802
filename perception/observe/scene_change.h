// SPDX-License-Identifier: Apache-2.0
// Whether anything as large as a limb has moved between two pictures of a still camera: the only check while the
// engine rests.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"

namespace im2fit {

// No allocation after construction; not shareable between threads; integers only, about 40,000 instructions a frame
// whatever its size.
class SceneChange {
 public:
  // Of pictures of this size, sides of 1 px and more.
  SceneChange(int width, int height);
  // Keeps the picture that later ones are compared with. `depth`: mm, 0 = no data, of the constructor's size.
  void keep(DepthView depth);
  // Whether half of the sampled pixels in a block of a twentieth of the picture's long side have another depth than
  // in the kept picture, or have lost or gained data. True while no picture is kept.
  bool changed(DepthView depth) const;
  void forget() { kept_ = false; }

 private:
  // A pixel is as it was while its depth is `least_mm` to `least_mm + span_mm`.
  struct Range {
    std::uint16_t least_mm = 0;
    std::uint16_t span_mm = 0;
  };
  int step_px_;
  int columns_, rows_;  // of sampled pixels
  bool kept_ = false;
  std::vector<Range> ranges_;
  mutable std::vector<std::uint8_t> counts_;  // of a row of blocks
};

}  // namespace im2fit
