// SPDX-License-Identifier: Apache-2.0
// How bodies differ beyond what the body model can express: smooth bumps, asymmetry.
#pragma once

#include <span>

#include "base/rng.h"
#include "body/model.h"

namespace im2fit::synth {

// Smooth displacements along the normals: `count` bumps or dents of reach 120..320 mm between knees and chin, each
// up to amplitude_mm. Added to offset_mm (one per body vertex).
void add_bumps(const body::BodyModel& model, std::span<const Vec3f> rest, int count, float amplitude_mm, Rng& rng,
               std::span<Vec3f> offset_mm);
// Low-frequency left-right asymmetry: the trunk leans out sideways and one side is fuller, up to amplitude_mm.
void add_asymmetry(const body::BodyModel& model, std::span<const Vec3f> rest, float amplitude_mm, Rng& rng,
                   std::span<Vec3f> offset_mm);

}  // namespace im2fit::synth
