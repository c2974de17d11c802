// SPDX-License-Identifier: Apache-2.0
// Differences of bodies that the body model cannot express: smooth bumps, asymmetry.
#pragma once

#include <span>

#include "body/model.h"
#include "core/rng.h"

namespace im2fit::lab {

// Smooth displacements along the normals. Their centres lie between two shares of the height, `aside_mm` at most
// from the middle.
struct Bumps {
  int count = 6;  // bumps or dents
  float reach_least_mm = 120, reach_most_mm = 320;
  float low = 0.28F, high = 0.86F;  // knees to chin
  float aside_mm = 1e9F;
};
// Each up to amplitude_mm. Added to offset_mm (one per body vertex).
void add_bumps(const body::BodyModel& model, std::span<const Vec3f> rest, const Bumps& bumps, float amplitude_mm,
               Rng& rng, std::span<Vec3f> offset_mm);
// Low-frequency left-right asymmetry: the trunk leans out sideways and one side is fuller, up to amplitude_mm.
void add_asymmetry(const body::BodyModel& model, std::span<const Vec3f> rest, float amplitude_mm, Rng& rng,
                   std::span<Vec3f> offset_mm);

// A crown that is higher, or flatter: all of it above the ears, smoothly less towards them.
void raise_crown(const body::BodyModel& model, std::span<const Vec3f> rest, float up_mm, std::span<Vec3f> offset_mm);

// What makes people differ as people do, alike on both sides of x = 0. Smooth, drawn anew for each person; of no
// modifier.
struct Mirrored {
  float low = 0.45F, high = 0.82F;  // where centres are, shares of the height: trunks, from the crotch to the chin
  // Along the normals, a bump or dent and its image.
  int bumps = 0;
  float bump_least_mm = 0, bump_most_mm = 0;  // of a person's, drawn evenly
  float bump_reach_least_mm = 110, bump_reach_most_mm = 330;
  double uneven_share = 0.2;  // of bumps whose image has a size of its own
  // Up or down with all that lies within reach: the height of a navel depends little on the shape about it.
  int slides = 0;
  double slide_sd_mm = 0;
  float slide_reach_least_mm = 120, slide_reach_most_mm = 250;
  // Parts moved forwards or back and stretched, smoothly less away from a centre on the trunk's axis.
  int warps = 0;
  double warp_sd_mm = 0;       // forwards; 0.4 of it upwards
  double warp_stretch_sd = 0;  // of widths and depths
  float warp_reach_least_mm = 180, warp_reach_most_mm = 420;
  // All that is about as high, arms too, moved forwards or back, as spines are bent.
  int shifts = 0;
  double shift_sd_mm = 0;
  float shift_reach_least_mm = 180, shift_reach_most_mm = 350;
};
void add_mirrored(const body::BodyModel& model, std::span<const Vec3f> rest, const Mirrored& mirrored, Rng& rng,
                  std::span<Vec3f> offset_mm);

}  // namespace im2fit::lab
