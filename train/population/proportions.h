// SPDX-License-Identifier: Apache-2.0
// Proportions of measured people: dimensions drawn as they go together in ANSUR II, and the warp that gives a mesh
// them.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "body/model.h"
#include "body/warp.h"
#include "core/rng.h"

namespace im2fit::body {

// As ANSUR II names and measures them (Hotzman et al., NATICK/TR-11/017), mm. Heights are from the floor.
enum class Dimension : unsigned char {
  cervicale_height,
  acromial_height,
  chest_height,
  waist_height,  // of the navel, as the waist's other dimensions
  buttock_height,
  crotch_height,
  knee_height,
  biacromial_breadth,
  bideltoid_breadth,
  chest_depth,
  chest_girth,
  waist_breadth,
  waist_depth,
  waist_girth,
  hip_breadth,
  buttock_depth,
  buttock_girth,
  neck_girth,
  thigh_girth,
  calf_girth,
  biceps_girth_flexed,
  forearm_girth_flexed,
  upper_arm_length,  // acromion to radiale
  forearm_length,    // radiale to stylion
  head_breadth,
  head_length,
};
inline constexpr std::size_t kDimensionCount = 26;
struct Dimensions {
  std::array<double, kDimensionCount> mm{};
  double& operator[](Dimension d) { return mm[static_cast<std::size_t>(d)]; }
  double operator[](Dimension d) const { return mm[static_cast<std::size_t>(d)]; }
};

// The most likely dimensions plus what people differ by (`z`: standard normal draws, limited by the caller).
Dimensions likely_dimensions(bool woman, double stature_mm, double weight_kg, double age_years,
                             const std::array<double, kDimensionCount>& z);

// The facts of a section that no survey by tape and calliper measures, and that are varied: how far out its corners
// are, and how much of its depth lies in front of the middle.
struct SectionVariety {
  float square = 0, front_more = 0;
};
struct Variety {
  SectionVariety hip, waist, chest;
  float head_rise = 0;  // of the skull's base under the crown, share of the stature
};
Variety draw_variety(Rng& rng);

// The warp after which a rest mesh without one has these dimensions at its own stature: level sections to a
// millimetre, limbs and heights to a few. A dimension far from the mesh's own is met as far as the warp's limits go.
// Two milliseconds.
Warp warp_to(const BodyModel& model, std::span<const Vec3f> rest, const Dimensions& wanted, const Variety& variety);

// The same dimensions of a mesh, taken as a tape and a calliper would be put round it: hulls of sections; breadths
// and depths of the trunk's sections are those of the hull (chest depth, too).
Dimensions dimensions_of(const BodyModel& model, std::span<const Vec3f> rest);

}  // namespace im2fit::body
