// SPDX-License-Identifier: Apache-2.0
// The section profile: level cuts of trunk, legs and head (half widths, front relief, arc length), arm widths, crown
// and sole heights, joints and bone lengths. Many sections together beat one ellipse; the values
// are raw material for the index' learned projection, so none of them needs to be a measurement by itself.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/joints.h"
#include "kernels/contour/contour.h"
#include "kernels/rayform/ray_form.h"
#include "kernels/unproject/unproject.h"
#include "perception/profile/person_frame.h"

namespace im2fit {

// Layout of the profile, in order. Missing values are NaN.
struct ProfileLayout {
  static constexpr int kTrunkLevels = 30;                // stature fractions 0.44 .. 0.84
  static constexpr int kReliefs = 9;                     // at -0.8 .. 0.8 of the half width
  static constexpr int kTrunkValues = 2 + kReliefs + 1;  // left, right, reliefs, front arc length
  static constexpr int kLegLevels = 20;                  // 0.05 .. 0.45
  static constexpr int kLegValues = 4;                   // left width, right width, left depth, right depth
  static constexpr int kHeadLevels = 14;                 // 0.82 .. 0.98
  static constexpr int kHeadValues = 4;                  // width, reliefs at -0.5, 0, 0.5
  static constexpr int kArmValues = 12;                  // two arms, two bones, at 1/4, 1/2, 3/4
  static constexpr int kCrownValues = 5;
  static constexpr int kSoleValues = 4;
  static constexpr int kBones = 14;
  static constexpr int kScene = 8;

  static constexpr int kTrunk = 0;
  static constexpr int kLegs = kTrunk + kTrunkLevels * kTrunkValues;
  static constexpr int kHead = kLegs + kLegLevels * kLegValues;
  static constexpr int kArms = kHead + kHeadLevels * kHeadValues;
  static constexpr int kCrown = kArms + kArmValues;
  static constexpr int kSoles = kCrown + kCrownValues;
  static constexpr int kJoints = kSoles + kSoleValues;
  static constexpr int kBoneLengths = kJoints + 3 * static_cast<int>(kJointCount);
  static constexpr int kSceneValues = kBoneLengths + kBones;
  static constexpr int kSize = kSceneValues + kScene;
};

// Buffers sized once, for pictures up to width x height.
class ProfileWorkspace {
 public:
  explicit ProfileWorkspace(int width_max = kImageSideMax, int height_max = kImageSideMax);
  RayTable rays;
  RayForm up, side;                 // heights and sideways positions of all pixels
  std::vector<ContourRow> outline;  // of each row
  std::vector<std::uint64_t> seen, steps;
  std::vector<std::uint64_t> squares;  // by height: see kernels/height
  std::vector<float> level_sum;
  std::vector<float> level_weight;
};

// `depth_q4` in 1/16 mm, 0 = none; only masked pixels count. out: ProfileLayout::kSize values, all NaN where the
// torso is nowhere or in the floor's normal through the camera. Sums over the picture are exact integers, the rest
// floats in written order: the same bits on every machine. No allocation after construction, no threads.
void section_profile(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                     const JointSet& joints, const FloorPlane& floor, ProfileWorkspace& work, std::span<float> out);

}  // namespace im2fit
