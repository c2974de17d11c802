// SPDX-License-Identifier: Apache-2.0
// The truth about people of the family `other`, by a section cutter of its own at landmarks of its own (ISO 8559-1's
// definitions, core/measurement.h): what measures the product's answers shares no code with body/measure.h nor
// body/tape.h.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "body/skeleton.h"
#include "core/measurement.h"
#include "core/vec3.h"
#include "evaluation/population/body_dimensions.h"
#include "train/population/actor.h"

namespace im2fit::lab {

// Length of the tape round a plane section: of its points' convex hull, mm; 0 where the plane meets no triangle.
// `used`: of each triangle, 0 leaves it out; empty: all count.
double tape_round(std::span<const Vec3f> vertices, std::span<const std::array<std::int32_t, 3>> triangles,
                  std::span<const std::uint8_t> used, Vec3f origin, Vec3f normal);

// Litres within a closed surface.
double volume_within(std::span<const Vec3f> vertices, std::span<const std::array<std::int32_t, 3>> triangles);

// Arms of the pose that people are measured in: 10 degrees off the body (slim) to 22 (obese).
float measuring_spread_deg(double litres_per_m2);

// Heights of the sections above the floor, mm, in that pose.
struct ActorLevels {
  float chest = 0, waist = 0, hip = 0;
};
ActorLevels levels_of(const Actor& actor, const DimensionSurface& parts);

// Round thigh, calf and upper arm, mm, mean of left and right, in that pose: by the words of `mid_thigh_girth`,
// `calf_girth` and `upper_arm_girth` in data/tape, between this rig's joints. NaN: no section.
struct LimbGirths {
  double mid_thigh = 0, calf = 0, upper_arm = 0;
};
LimbGirths limb_girths_of(const Actor& actor, const DimensionSurface& parts);

// Measured standing in that pose. What has no definition on these landmarks is NaN: the inside leg, because a web
// joins the scans' thighs, down to 77 mm below the survey's crotch on the mean man. Weight: the volume at rest by the
// density law of body/measure.h.
MeasurementValues measure_actor(const Actor& actor, const DimensionSurface& parts);

}  // namespace im2fit::lab
