// SPDX-License-Identifier: Apache-2.0
// From one depth frame to the mask of the person to be measured: floor plane, background, blobs, choice.
// No allocation after construction, no threads; not shareable between threads.
#pragma once

#include <cstdint>
#include <memory>

#include "kernels/core/camera.h"
#include "kernels/core/guidance.h"

namespace im2fit {

struct FloorPlane {
  bool known = false;
  Vec3f up;                    // unit, away from the floor, camera axes (about {0,-1,0} for a level camera)
  float camera_height_mm = 0;  // the camera's distance above the floor; height of p = dot(up, p) + camera_height_mm
};

struct Person {
  bool found = false;
  int people_count = 0;                              // people in view, the chosen one included
  int u_min = 0, v_min = 0, u_max = -1, v_max = -1;  // px, box of the mask, inclusive
  int pixel_count = 0;
  Vec3f centroid_mm;
  bool cut_top = false, cut_bottom = false, cut_left = false, cut_right = false;  // the mask touches that border
  FloorPlane floor;
  GuidanceSet guidance = 0;  // no_person, too_near, too_far, feet_cut, head_cut, side_cut, several_people, too_noisy
};

class Segmenter {
 public:
  Segmenter(int width, int height);
  ~Segmenter();
  Segmenter(Segmenter&&) noexcept;
  Segmenter& operator=(Segmenter&&) noexcept;

  // `depth` and `mask` have the constructor's size; both upright (camera rolled by 12 degrees at most). Pixels of 0
  // or more than 10,000 mm are no data. With the floor unknown, heights are along the picture's vertical.
  Person run(DepthView depth, const Intrinsics& intrinsics, MaskImage mask);
  void reset();  // forgets the floor and the background

 private:
  struct Workspace;
  std::unique_ptr<Workspace> work_;
};

}  // namespace im2fit
