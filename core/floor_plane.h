// SPDX-License-Identifier: Apache-2.0
// The floor as a frame shows it.
#pragma once

#include "core/vec3.h"

namespace im2fit {

struct FloorPlane {
  bool known = false;
  // Unit, upwards, camera axes: about {0,-1,0} for a level camera. Of an unknown floor gravity's, where that is
  // known.
  Vec3f up = {0, -1, 0};
  float camera_height_mm = 0;  // the camera's distance above the floor; height of p = dot(up, p) + camera_height_mm
};

}  // namespace im2fit
