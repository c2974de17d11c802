// SPDX-License-Identifier: Apache-2.0
// A camera held in the hand: turned a little from frame to frame, about its own centre.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "hal/steady_view.h"

namespace im2fit::lab {

// Each of the three angles is a sum of slow sway (0.3 and 0.9 Hz) and of a hand's tremor (2 and 9 Hz), at frames of
// 30 Hz; `amplitude_deg` is what each reaches at most. Samples come from the nearest pixel; what was outside the
// picture has no data.
class Tremor {
 public:
  Tremor(float amplitude_deg, std::uint64_t seed, const Intrinsics& k);
  // Radians about x, y and z.
  struct Turn {
    double x = 0, y = 0, z = 0;
  };
  Turn at(std::uint64_t frame) const;
  // The same as a device tells it.
  hal::CameraPose pose(std::uint64_t frame) const;
  // In place.
  void run(std::uint64_t frame, DepthImage picture);

 private:
  double amplitude_rad_;
  std::uint64_t seed_;
  Intrinsics k_;
  std::vector<std::uint16_t> before_;
};

}  // namespace im2fit::lab
