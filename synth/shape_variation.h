// SPDX-License-Identifier: Apache-2.0
// How bodies differ beyond what the body model can express: smooth bumps, asymmetry.
#pragma once

#include <span>

#include "base/rng.h"
#include "body/model.h"

namespace im2fit::synth {

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

}  // namespace im2fit::synth
