// SPDX-License-Identifier: Apache-2.0
// What stands still in the room while the camera does: the farthest depth of each cell that lasts. Learned only where
// no person is or was lately, so that a person who stands still does not become furniture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/segment/grid.h"

namespace im2fit::segment {

struct Keepout;

class Background {
 public:
  explicit Background(const Grid& grid);
  void reset();
  // Compares a new frame; forgets all when its camera seems to have moved.
  void observe(const Grid& grid, const FloorPlane& floor);
  // 1 per cell of this frame that shows the background.
  std::span<const std::uint8_t> shown() const { return shown_; }
  // Takes the frame in. Cells about the keepouts are not learned, and those with `taken` != 0 unlearned.
  void learn(const Grid& grid, std::span<const Keepout> keepouts, std::span<const std::uint8_t> taken);

 private:
  bool floor_moved(const FloorPlane& floor) const;
  bool compare(const Grid& grid);
  void keep_out(const Grid& grid, std::span<const Keepout> keepouts);

  std::vector<std::uint16_t> depth_;    // 1/4 mm; 0: none yet
  std::vector<std::uint8_t> evidence_;  // frames, fewer by those that showed something nearer
  std::vector<std::uint8_t> kept_out_;
  std::vector<std::uint8_t> shown_;
  FloorPlane floor_;  // when learning began
};

}  // namespace im2fit::segment
