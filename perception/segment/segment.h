// SPDX-License-Identifier: Apache-2.0
// From one depth frame to the people in it and the mask of the one to be measured: floor plane, background, blobs,
// people, choice. No allocation after construction, no threads; not shareable between threads.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/camera.h"
#include "core/floor_plane.h"
#include "core/guidance.h"

namespace im2fit {

// One of the people of a frame, as the coarse picture shows them (cells of 4 px at 640x480).
struct User {
  int id = 0;  // >= 1; stays while the person is seen, or hidden for 5 s at most; never given to another person
  int u_min = 0, v_min = 0, u_max = -1, v_max = -1;  // px, box, inclusive
  int pixel_count = 0;                               // of the cells
  Vec3f centroid_mm;                                 // of the cells
  Vec3f head_mm;            // crown, as the camera sees it; without has_head the topmost cell seen last
  bool has_head = false;    // a head is seen in this frame
  float visible_share = 1;  // of the surface seen of this person at best, 0..1: less behind others
  bool confirmed = false;   // a person in three frames or in the first, and in a fifth of those since
};
inline constexpr int kUserCountMax = 8;

struct Person {
  bool found = false;
  int id = 0;                                        // of the User measured; 0: none
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
  // `seconds`: since the frame before, for those who walk or are hidden.
  Person run(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds = 1.0F / 30.0F);
  // The people of the last frame, at most kUserCountMax, nearest first; valid until the next run or reset.
  std::span<const User> users() const;
  // Whom to measure from the next frame on: the user of this id and no other, even while hidden or gone;
  // 0 (default): the nearest and most central one.
  void select(int id);
  // Unconfirmed candidates stay selectable until rejected. true: that user is furniture; from the next frame on
  // others are chosen before it, and it does not count as another person in view. false: it is a person, and
  // confirmed by this. Ends with reset().
  void set_rejected(int id, bool rejected);
  // How much more that user's surface is shaped like a person's than like furniture, mean over the last frames:
  // log-odds, from -9 to 9; 0 for a user not seen whole or unknown. An unconfirmed candidate may be found: its shape
  // alone does not decide, so confirmed users are chosen before it, and the caller should judge it by its joints.
  float shape_odds(int id) const;
  void reset();  // forgets the floor, the background and all users; ids go on; the selection ends

 private:
  struct Workspace;
  std::unique_ptr<Workspace> work_;
};

}  // namespace im2fit
