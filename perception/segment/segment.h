// SPDX-License-Identifier: Apache-2.0
// From one depth frame to the people in it and the mask of the one to be measured: floor plane, background, blobs,
// and the mask of the user PersonTracker chooses. No allocation after construction, no threads; not shareable
// between threads.
#pragma once

#include <memory>
#include <optional>

#include "core/camera.h"
#include "core/floor_plane.h"
#include "core/guidance.h"
#include "perception/segment/person_tracker.h"

namespace im2fit {

struct Person {
  bool found = false;
  int id = 0;                                        // of the User looked at; 0: none
  int people_count = 0;                              // people in view, the chosen one included
  int u_min = 0, v_min = 0, u_max = -1, v_max = -1;  // px, box of the mask, inclusive
  int pixel_count = 0;
  Vec3f centroid_mm;
  bool cut_top = false, cut_bottom = false, cut_left = false, cut_right = false;  // the mask touches that border
  FloorPlane floor;
  // no_person, too_near, too_far, feet_cut, head_cut, side_cut, several_people, too_noisy, step_to_the_middle,
  // depth_missing
  GuidanceSet guidance = 0;
};

class Segmenter {
 public:
  Segmenter(int width, int height);
  ~Segmenter();
  Segmenter(Segmenter&&) noexcept;
  Segmenter& operator=(Segmenter&&) noexcept;

  // `depth` and `mask` have the constructor's size; both upright (camera rolled by 12 degrees at most). Pixels of 0
  // or more than 10,000 mm are missing data. With the floor unknown, heights are along `up` (against gravity), or
  // along the picture's vertical when `up` is unknown too.
  // `people` identifies the blobs and chooses one of them; pass the same one for every frame. `seconds`: since the
  // frame before, to predict people who walk or are hidden.
  Person run(DepthView depth, const Intrinsics& intrinsics, PersonTracker& people, MaskImage mask,
             float seconds = 1.0F / 30.0F, const std::optional<Vec3f>& up = std::nullopt);
  void reset();  // forgets the floor and the background; reset the people as well

 private:
  struct Workspace;
  std::unique_ptr<Workspace> work_;
};

}  // namespace im2fit
