// SPDX-License-Identifier: Apache-2.0
#include "index/clothing_estimate.h"

#include <algorithm>
#include <cmath>

#include "index/format.h"
#include "index/index.h"
#include "kernels/standardise/standardise.h"

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
    : view_(view),
      contents_(contents),
      feature_size_(feature_size),
      mean_(floats_of(contents.mean)),
      scale_(floats_of(contents.scale)),
      regressor_(contents.weights, contents.unit, contents.bias) {}

ClothingEstimator::Work::Work(const ClothingEstimator& estimator)
    : values(estimator.contents_.mean.size()), standardised(estimator.regressor_.padded_size()) {}

bool ClothingEstimator::applies(const Seen& seen) const {
  const std::size_t fit_size = contents_.record.fit.size();
  return seen.front.size() == feature_size_ && seen.fit.size() == fit_size &&
         (!sees_back(view_) || (seen.back.size() == feature_size_ && seen.fit_both.size() == fit_size));
}

float ClothingEstimator::probability(const Seen& seen, Work& work) const {
  refined_values(view_, seen, contents_.record.fit, work.values);
  im2fit::standardise(work.values.data(), mean_.data(), scale_.data(), static_cast<int>(work.values.size()),
                      work.standardised.data());
  return probability_at(contents_.table, regressor_(work.standardised)[0]);
}

float with_given(float probability, ClothingGiven given) {
  if (given == ClothingGiven::dressed) return 1;
  float dressed = probability;
  if (given == ClothingGiven::bare)
    dressed = probability * kToldBareOdds / (probability * kToldBareOdds + (1 - probability));
  return dressed < kNegligible ? 0 : dressed;
}

void mix_answers(const Answer& bare, const Answer& dressed, float probability, Answer& out) {
  constexpr float kSdsOf95 = 1.96F;
  const float p = probability, q = 1 - probability;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const IntervalEstimate& a = bare.measurements[m];
    const IntervalEstimate& b = dressed.measurements[m];
    const float value = q * a.value + p * b.value;
    const float apart = p * q * squared(kSdsOf95 * (b.value - a.value));
    const float below = q * squared(a.value - a.low) + p * squared(b.value - b.low) + apart;
    const float above = q * squared(a.high - a.value) + p * squared(b.high - b.value) + apart;
    out.measurements[m] = {value, value - std::sqrt(below), value + std::sqrt(above)};
  }
  out.female = q * bare.female + p * dressed.female;
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
