// SPDX-License-Identifier: Apache-2.0
// How each size of a garment would sit on a body, and which to buy (docs/garments.md).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "body/tape.h"
#include "core/status.h"
#include "garment/pattern.h"
#include "person/size_chart.h"
#include "person/size_fit.h"
#include "person/tape_regression.h"
#include "person/wardrobe.h"

namespace im2fit {

// The chest girth a size is cut for: the middle of its row.
float size_chest_mm(const SizeRow& row);

// Of a chart with chest girths: that is what garments are cut by (SizeSystem::cut_by).
GarmentFit fit_garment(const body::GarmentPattern& pattern, const body::CutRegression& regression,
                       const SizeChart& chart, bool woman, std::span<const BodyGirth> girths);
// In words for people: "M; then L, in which the chest is loose (150 mm of ease, 70 in M)".
std::string advice_words(const GarmentFit& fit);

// The girths that a pattern's regions name, from the body's tape values and their intervals (as many intervals as
// values, or none). Error: a region names an unknown measurement of the tape, or one the body does not have.
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
// The default clothes of an avatar: trousers and a T-shirt, each in the best size of `fits`.
std::vector<Worn> everyday_clothes(const Wardrobe& wardrobe, std::span<const GarmentFit> fits);

}  // namespace im2fit
