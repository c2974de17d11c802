// SPDX-License-Identifier: Apache-2.0
// The constants of split_furniture.cpp: what each bounds and where it comes from. Source:
//   [touch] a person whose hand touches a box is found, arms and legs apart stay whole (tests/perception/
//           segment_furniture_test.cpp); no other measurement on record
#pragma once

namespace im2fit::segment::split_furniture_limits {

inline constexpr float kBesideMm = 500.0F;   // from the head sideways, least: further than a trunk's sides; [touch]
inline constexpr float kNearestMm = 300.0F;  // what is upright further out is taken to here, least: legs are; [touch]
inline constexpr float kLowMm = 450.0F;      // above the floor: what begins lower stands on it, or is a leg; [touch]
inline constexpr float kUprightMm = 500.0F;  // of a column, least: an arm or a slanting leg has 250 there; [touch]

}  // namespace im2fit::segment::split_furniture_limits
