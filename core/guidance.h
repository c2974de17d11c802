// SPDX-License-Identifier: Apache-2.0
// What the person or the scene must change, as codes instead of free text.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace im2fit {

enum class Guidance : std::uint32_t {
  no_person = 1U << 0,
  too_near = 1U << 1,
  too_far = 1U << 2,
  feet_cut = 1U << 3,
  head_cut = 1U << 4,
  arms_close = 1U << 5,
  not_frontal = 1U << 6,
  not_upright = 1U << 7,
  moving = 1U << 8,
  several_people = 1U << 9,
  too_noisy = 1U << 10,
  side_cut = 1U << 11,          // an arm or side is outside the picture
  calibration_pose = 1U << 12,  // raise the arms: Psi
  turn_round = 1U << 13,        // show the back; set by the session
  clothed = 1U << 14,           // clothing is bare, but clothes were detected; accompanies a measurement
  turn_on = 1U << 15,           // make one slow full turn on the spot; set by the session
  turn_slower = 1U << 16,       // turn or walk more slowly
  walk_round = 1U << 17,        // for the holder of the camera: continue round the person
  // Decided after accumulation by estimate/plausibility.h. These prevent a measurement:
  out_of_population = 1U << 18,  // shorter or taller than all training people
  floor_bent = 1U << 19,         // a flat floor is curved in the depth
  // These accompany a measurement:
  feet_raised = 1U << 20,  // the feet are above the floor; heights are measured from there
  head_unseen = 1U << 21,  // the top of the head has no depth
  // Decided for a frame:
  step_to_the_middle = 1U << 22,  // the person cannot be separated from a wall or shelf
  depth_missing = 1U << 23,       // a part of the body has no depth: dark or shiny clothes
};
inline constexpr int kTooFarMm = 4000;  // people further away than this are too_far
inline constexpr std::size_t kGuidanceCount = 24;
inline constexpr std::array<std::string_view, kGuidanceCount> kGuidanceNames = {
    "NO_PERSON",         "TOO_NEAR",    "TOO_FAR",     "FEET_CUT",       "HEAD_CUT",           "ARMS_CLOSE",
    "NOT_FRONTAL",       "NOT_UPRIGHT", "MOVING",      "SEVERAL_PEOPLE", "TOO_NOISY",          "SIDE_CUT",
    "CALIBRATION_POSE",  "TURN_ROUND",  "CLOTHED",     "TURN_ON",        "TURN_SLOWER",        "WALK_ROUND",
    "OUT_OF_POPULATION", "FLOOR_BENT",  "FEET_RAISED", "HEAD_UNSEEN",    "STEP_TO_THE_MIDDLE", "DEPTH_MISSING"};
using GuidanceSet = std::uint32_t;  // bitwise OR of Guidance values
constexpr GuidanceSet operator|(Guidance a, Guidance b) {
  return static_cast<GuidanceSet>(a) | static_cast<GuidanceSet>(b);
}
constexpr bool has(GuidanceSet set, Guidance g) {
  return (set & static_cast<GuidanceSet>(g)) != 0;
}
// In a frame in which no person is found, these codes show that somebody is present.
inline constexpr GuidanceSet kThereButNotFound =
    (Guidance::too_near | Guidance::step_to_the_middle) | static_cast<GuidanceSet>(Guidance::depth_missing);
// Bits for the person's own arms: those to which ARMS_CLOSE refers.
using ArmSet = std::uint32_t;
inline constexpr ArmSet kLeftArm = 1U << 0, kRightArm = 1U << 1;
inline constexpr std::size_t kArmCount = 2;
inline constexpr std::array<std::string_view, kArmCount> kArmNames = {"left", "right"};

inline std::vector<std::string_view> names_of_arms(ArmSet set) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < kArmCount; ++i)
    if ((set >> i & 1U) != 0) names.push_back(kArmNames[i]);
  return names;
}

// The codes of a set, in the order of their bits.
inline std::vector<std::string_view> names_of(GuidanceSet set) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < kGuidanceCount; ++i)
    if ((set >> i & 1U) != 0) names.push_back(kGuidanceNames[i]);
  return names;
}

}  // namespace im2fit
