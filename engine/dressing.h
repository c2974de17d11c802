// SPDX-License-Identifier: Apache-2.0
// From a measured body to clothes on it: what each size of a garment would be like, and the body dressed.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "body/garment/outfit.h"
#include "body/tape.h"
#include "engine/garment_fit.h"
#include "engine/size_chart.h"
#include "engine/tape_law.h"
#include "engine/wardrobe.h"

namespace im2fit {

// The girths a pattern's regions speak of, from what the tape measures of the body and how well each is known (as
// many intervals as values, or none). Error: a region names no measurement of the tape, or one the body does not
// have.
Result<std::vector<BodyGirth>> girths_for(const body::GarmentPattern& pattern, const body::Tape& tape,
                                          std::span<const float> values, std::span<const TapeInterval> intervals);
// A fit of every garment, in the wardrobe's order; one whose girths the body does not have is left out. Women's chart
// and bodies when `female` is above a half.
std::vector<GarmentFit> fits_of(const Wardrobe& wardrobe, const SizeSystem& charts, float female,
                                const body::Tape& tape, std::span<const float> values,
                                std::span<const TapeInterval> intervals);

// A garment in one size.
struct Worn {
  const body::GarmentPattern* pattern = nullptr;
  float chest_mm = 0;  // the size is cut for
};
// What an avatar wears unless told otherwise: trousers and a T-shirt, each in the best size of `fits`.
std::vector<Worn> everyday_clothes(const Wardrobe& wardrobe, std::span<const GarmentFit> fits);

// The tape put round a body, and everyday clothes of the best sizes on it.
Result<std::unique_ptr<body::Outfit>> dress_everyday(const Wardrobe& wardrobe, const SizeSystem& charts,
                                                     const body::BodyModel& model, const body::Params& params,
                                                     const body::Pose& pose, float female);

// `worn`: the lowest first. A tenth of a second a garment. `moves`: for body::MovingClothes, too. Errors: a garment's
// fabric is not in the wardrobe.
Result<std::unique_ptr<body::Outfit>> dress(const Wardrobe& wardrobe, const body::BodyModel& model,
                                            const body::Params& params, const body::Pose& pose, bool woman,
                                            std::span<const Worn> worn, bool moves = false);

}  // namespace im2fit
