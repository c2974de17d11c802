// SPDX-License-Identifier: Apache-2.0
// People and pictures made unlike what the models know: other sizes, raised heels, a skirt to the floor, crowns
// without depth, wrong lenses.
#pragma once

#include <span>
#include <vector>

#include "evaluation/measurements/evaluation.h"

namespace im2fit::lab {

// Makes the person `stature_mm` tall, in the proportions of the adult; of children the head shrinks by the square
// root of the rest alone. Of an actor the mesh and its bones.
void resize(const body::BodyModel& model, float stature_mm, bool child, HeldOutPerson& person);

// The heels of a rest mesh stand `heel_mm` above the balls of the feet, as in shoes; the toes lie flat.
void raise_heels(const body::BodyModel& model, float heel_mm, std::vector<Vec3f>& rest);

// A skirt from the hips to `gap_mm` above the floor, `flare_mm` wider there than what it hangs from. The model must
// outlive it.
Dresser long_skirt(const body::BodyModel& model, float gap_mm, float flare_mm, std::uint64_t seed);

// No depth of the head from `lost_mm` below the crown on, when the crown is `stature_mm` above the floor.
PictureChange lose_crown(float stature_mm, float lost_mm);
// Distances from the camera in place of depths.
PictureChange give_range();
// A lens with this radial coefficient, which nobody undoes.
PictureChange distort(float k1);

}  // namespace im2fit::lab
