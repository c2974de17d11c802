// SPDX-License-Identifier: Apache-2.0
// Clothes for a measured body: the fit of each size of a garment, and the dressed body.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "body/tape.h"
#include "garment/drape/outfit.h"
#include "person/garment_fit.h"
#include "person/size_chart.h"
#include "person/tape_regression.h"
#include "person/wardrobe.h"

namespace im2fit {

// The tape put round a body, and everyday clothes of the best sizes on it.
Result<std::unique_ptr<body::Outfit>> dress_everyday(const Wardrobe& wardrobe, const SizeSystem& charts,
                                                     const body::BodyModel& model, const body::Params& params,
                                                     const body::Pose& pose, float female);

// `worn`: the lowest first. A tenth of a second a garment. `moves`: for body::MovingClothes, too. Errors: a garment's
// fabric is not in the wardrobe.
Result<std::unique_ptr<body::Outfit>> dress(const Wardrobe& wardrobe, const body::BodyModel& model,
                                            const body::Params& params, const body::Pose& pose, bool woman,
                                            std::span<const Worn> worn, bool moves = false);

// The same on a body that was morphed before. `rest`: all of the model's vertices; `skeleton`: theirs.
Result<std::unique_ptr<body::Outfit>> dress(const Wardrobe& wardrobe, const body::BodyModel& model,
                                            std::span<const Vec3f> rest, const body::Skeleton& skeleton,
                                            const body::Pose& pose, bool woman, std::span<const Worn> worn,
                                            bool moves = false);

}  // namespace im2fit
