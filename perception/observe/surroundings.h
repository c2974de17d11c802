// SPDX-License-Identifier: Apache-2.0
// What lies about a person who is accumulated: the floor, the ground under the feet, and the picture above the head.
// What follows from it is decided in estimate/plausibility.h.
#pragma once

#include <array>
#include <cstdint>

#include "core/camera.h"
#include "core/joints.h"
#include "perception/observe/floor_bend.h"
#include "perception/segment/segment.h"

namespace im2fit {

// Means over the frames that showed it.
struct SurroundingsSigns {
  FloorBend floor;
  // The ground within 170 mm of the feet, feet included: the level that most of it has, above the floor; the share of
  // the ground at that level, and at the floor's. Areas as seen from above.
  bool ground_known = false;
  float ground_mm = 0, ground_share = 0, floor_share = 0;
  // Of both feet of a person who faces the camera, along the floor towards it from the shin: the foremost of the
  // toes, and the front of the ankle.
  bool feet_known = false;
  float toe_reach_mm = 0, ankle_ahead_mm = 0;
  // Pixels without depth, of the 80 mm above the mask's top and of as much beside the head.
  bool above_known = false;
  float lost_above_share = 0, lost_beside_share = 0;
};

// No allocation after construction. + - * / and sqrt in written order: the same bits on every machine.
class Surroundings {
 public:
  Surroundings(int width, int height) : bend_(width, height) {}
  void reset();
  // A frame of the person `person`, whose mask is `mask`. `facing`: the front is towards the camera.
  void add(DepthView depth, MaskView mask, const Intrinsics& intrinsics, const Person& person, bool facing = true);
  SurroundingsSigns signs() const;

 private:
  static constexpr int kToesBins = 160;
  struct Foot {
    std::array<std::uint32_t, kToesBins> toes{};  // pixels, by how far forward
    int toe_count = 0, ankle_count = 0, shin_count = 0;
    float ankle_sum = 0, shin_sum = 0;
  };
  void add_ground(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, bool facing);
  void add_feet(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, int step, Vec3f middle);
  void judge_feet(SurroundingsSigns& out) const;
  void add_head(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person);

  FloorBendFitter bend_;
  SurroundingsSigns sum_;
  std::array<Foot, 2> feet_{};  // by side
  int bends_tried_ = 0, bends_ = 0, grounds_ = 0, heads_ = 0;
};

// How flat the head ends above: its breadth 6, 12 and 20 mm below the highest point, mean, as a share of its greatest
// breadth within 120 mm. Crowns are domes, 0.15 to 0.55; a head cut off level has 0.5 to 1. Not a number where no
// head is seen. `depth_q4` in 1/16 mm.
float crown_flatness(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                     const JointSet& joints, const FloorPlane& floor);

}  // namespace im2fit
