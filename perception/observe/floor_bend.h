// SPDX-License-Identifier: Apache-2.0
// Whether a flat floor is flat in the depth. A lens that is not undone, or distances from the camera in place of
// depths along its axis, bend every plane like a bowl, and every height with it.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/floor_plane.h"

namespace im2fit {

// The floor of a frame as 1/z = -(q.r) / (1 + bend |r|^2): r = (x/z, y/z, 1) a pixel's ray, |r|^2 without its 1, q as
// in segment/floor.h. Linear in q and bend, so the bend is found by least squares with the plane.
//   0      depth along the axis, through a lens that is undone
//   0.44   distance from the camera: sqrt(1 + |r|^2) over the rays of a room
//   about k1 of a radial lens that is not undone
struct FloorBend {
  bool known = false;
  float bend = 0;
};

// No allocation after construction. + - * / in written order: the same bits on every machine.
class FloorBendFitter {
 public:
  FloorBendFitter(int width, int height);
  // `mask`: the person, left out. `floor`: as found, known.
  FloorBend run(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const FloorPlane& floor);

 private:
  struct Ray {
    float x, y, inverse_z;
  };
  void collect(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const FloorPlane& floor);
  int step_;
  std::vector<Ray> rays_;
};

}  // namespace im2fit
