// SPDX-License-Identifier: Apache-2.0
// How likely a person is dressed, from all that is seen: a linear score of the same values as refined answers
// (index/refinement.h: folds show in the feature's histograms, hems and slack in what is off a fitted shape), learned
// on people seen bare and dressed in equal shares, then tabulated as a probability. How far the cloth lies off the
// skin follows from two answers about one person: as if bare, and as if dressed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "core/clothing.h"
#include "index/refinement.h"

namespace im2fit::index {

struct IntervalEstimate;
struct Answer;

// Of the front with its fit, and of both sides with theirs.
inline constexpr std::array kClothingViews = {Refinement::fitted, Refinement::turned};

// Of the file; fixed layout.
struct ClothingRecord {
  FitLayout fit;
  std::uint32_t sample_count = 0;        // learned from
  std::uint32_t penalty_millionths = 0;  // of the ridge, of the values' variance
  float right_share = 0;                 // of people it was not learned from, 0..1
};
static_assert(sizeof(ClothingRecord) == 24);

// Name of a section of the file: "dress1.mean" (front), "dress2.mean" (both sides).
std::string clothing_section_of(Refinement view, const char* name);

// Views into the file.
struct ClothingContents {
  ClothingRecord record;
  ValueMapContents map;          // to one score
  std::span<const float> table;  // kScoreTableSize probabilities, rising
};

// Applies one. As ValueMap.
class ClothingEstimator {
 public:
  ClothingEstimator(Refinement view, const ClothingContents& contents, std::size_t feature_size);
  const ValueMap& map() const { return map_; }
  // That more than close-fitting clothes are worn, 0..1, when half of all people do. No allocation.
  float probability(const Seen& seen, ValueMap::Work& work) const;

 private:
  std::span<const float> table_;
  ValueMap map_;
};

// The probability once it is known what was said: of ten people who say they are bare, nine are. Less than one in a
// hundred is 0.
float with_given(float probability, ClothingGiven given);

// One answer of two about the same person. Values are expected ones; an interval reaches as far as both answers' own
// widths and their distance make it, by `dressed`' probability.
void mix_answers(const Answer& bare, const Answer& dressed, float probability, Answer& out);

// Of cloth off the skin of the trunk, by what two answers about one person differ in: mean over chest, waist and
// hips, mm; not below 0.
float ease_between_mm(const Answer& bare, const Answer& dressed);

}  // namespace im2fit::index
