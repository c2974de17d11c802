// SPDX-License-Identifier: Apache-2.0
#include "index/clothing_estimate.h"

#include <algorithm>
#include <cmath>

#include "index/format.h"
#include "index/index.h"

namespace im2fit::index {
namespace {

constexpr float kToldBareOdds = 1.0F / 9;  // of being dressed all the same: judgement
constexpr float kNegligible = 0.01F;       // less likely than this counts as bare, to the bit

float squared(float x) {
  return x * x;
}

}  // namespace

std::string clothing_section_of(Refinement view, const char* name) {
  return (sees_back(view) ? "dress2." : "dress1.") + std::string(name);
}

ClothingEstimator::ClothingEstimator(Refinement view, const ClothingContents& contents, std::size_t feature_size)
    : table_(contents.table), map_(view, contents.record.fit, contents.map, feature_size) {}

float ClothingEstimator::probability(const Seen& seen, ValueMap::Work& work) const {
  return probability_at(table_, map_(seen, work)[0]);
}

float with_given(float probability, ClothingGiven given) {
  if (given == ClothingGiven::dressed) return 1;
  float dressed = probability;
  if (given == ClothingGiven::bare)
    dressed = probability * kToldBareOdds / (probability * kToldBareOdds + (1 - probability));
  return dressed < kNegligible ? 0 : dressed;
}

bool looks_dressed(const Answer& answer, ClothingGiven given) {
  return answer.clothed || with_given(answer.clothing.probability, given) >= 0.5F;
}

void widen_for(const Answer& dressed, float probability, Answer& bare) {
  constexpr float kSdsOf95 = 1.96F;
  const float p = probability, q = 1 - probability;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    IntervalEstimate& a = bare.measurements[m];
    const IntervalEstimate& b = dressed.measurements[m];
    const float expected = q * a.value + p * b.value;
    const float apart = p * q * squared(kSdsOf95 * (b.value - a.value));
    const float below = q * squared(a.value - a.low) + p * squared(b.value - b.low) + apart;
    const float above = q * squared(a.high - a.value) + p * squared(b.high - b.value) + apart;
    a.low = std::min(a.low, expected - std::sqrt(below));
    a.high = std::max(a.high, expected + std::sqrt(above));
  }
}

float ease_between_mm(const Answer& bare, const Answer& dressed) {
  constexpr float kTwoPi = 6.2831853F;
  float sum = 0;
  constexpr std::array kTrunk = {Measurement::chest_girth, Measurement::waist_girth, Measurement::hip_girth};
  for (const Measurement m : kTrunk)
    sum += bare.measurements[measurement_index(m)].value - dressed.measurements[measurement_index(m)].value;
  return std::max(sum / (kTwoPi * static_cast<float>(kTrunk.size())), 0.0F);
}

}  // namespace im2fit::index
