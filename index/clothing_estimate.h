// SPDX-License-Identifier: Apache-2.0
// The probability that a person is dressed: a linear score of the values behind refined answers (index/refinement.h:
// folds show in the feature's histograms, hems and slack in the distances from a fitted shape), learned on people
// seen bare and dressed in equal shares, then tabulated as a probability. The distance of the cloth from the skin
// follows from two answers about one person: one as if bare, one as if dressed.
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
  // That the person wears more than close-fitting clothes, 0..1, with a prior of one half. No allocation.
  float probability(const Seen& seen, ValueMap::Work& work) const;

 private:
  std::span<const float> table_;
  ValueMap map_;
};

// The probability given the specified clothing: nine of ten people specified as bare are bare. A result below 0.01
// becomes 0.
float with_given(float probability, ClothingGiven given);

// Whether the answer is of a dressed person, or of one who is told not to be (`given`) and is dressed more likely
// than not.
bool looks_dressed(const Answer& answer, ClothingGiven given);

// Widens the intervals of the answer as if bare by the probability of `dressed`: they then hold the interval of the
// mixture of both answers. Values stay: the estimate does not carry to other makes of people, so it only adds doubt.
void widen_for(const Answer& dressed, float probability, Answer& bare);

// The ease of the cloth at the trunk, from the differences of two answers about one person: mean over chest, waist
// and hips, mm; not below 0.
float ease_between_mm(const Answer& bare, const Answer& dressed);

}  // namespace im2fit::index
