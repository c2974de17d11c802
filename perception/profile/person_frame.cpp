// SPDX-License-Identifier: Apache-2.0
#include "perception/profile/person_frame.h"

namespace im2fit {

PersonFrame person_frame(const FloorPlane& floor, Vec3f centroid_mm) {
  PersonFrame frame;
  frame.up = floor.up;
  frame.camera_height_mm = floor.known ? floor.camera_height_mm : 0.0F;
  // Horizontal part of the way from person to camera.
  const Vec3f back = -centroid_mm;
  frame.toward = normalized(back - frame.up * dot(back, frame.up));
  frame.right = cross(frame.toward, frame.up);
  if (frame.right.x < 0) frame.right = -frame.right;
  frame.origin_mm = centroid_mm - frame.up * frame.height(centroid_mm);
  return frame;
}

}  // namespace im2fit
