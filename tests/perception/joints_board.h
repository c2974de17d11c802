// SPDX-License-Identifier: Apache-2.0
// A flat 40 x 60 px board in the middle of a 320 x 240 frame, 2 m away, for models whose answers are known.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/joints/tracker.h"

namespace im2fit::test {

struct Board {
  int width = 320, height = 240;
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(320 * 240, 0);
  std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(320 * 240, 0);
  Intrinsics k{320, 240, 288, 288, 159.5F, 119.5F};
  Person person;

  Board() { widen(180); }
  // From column 140 to `u_end`.
  void widen(int u_end) {
    for (int v = 90; v < 150; ++v) {
      for (int u = 140; u < u_end; ++u) {
        depth[static_cast<std::size_t>(v * width + u)] = 2000;
        mask[static_cast<std::size_t>(v * width + u)] = 255;
      }
    }
    person.found = true;
    person.u_min = 140;
    person.u_max = u_end - 1;
    person.v_min = 90;
    person.v_max = 149;
  }
  JointSet track(JointTracker& tracker, bool same_person = false) const {
    return tracker.track(DepthView(depth.data(), width, height), MaskView(mask.data(), width, height), k, person,
                         same_person);
  }
  JointSet track(const JointModel& model) const {
    JointTracker tracker(model);
    return track(tracker);
  }
};

}  // namespace im2fit::test
