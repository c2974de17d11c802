// SPDX-License-Identifier: Apache-2.0
// What is known of a person is evidence: it moves and narrows the answer, and is doubted where it cannot be.
#include "estimate/known_facts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace im2fit {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kStature = measurement_index(Measurement::stature);
constexpr std::size_t kWaist = measurement_index(Measurement::waist_girth);
constexpr std::size_t kWeight = measurement_index(Measurement::weight);

struct AnsweredPerson {
  index::Answer answer;
  AgeAnswer age;
};

// As the front says of most people: half of an interval about two standard deviations.
AnsweredPerson answered_person(index::AnsweredFrom from, bool clothed) {
  constexpr MeasurementValues kValues = {1750, 600, 900, 400, 380, 1150, 1000, 900, 1010, 790, 78};
  constexpr MeasurementValues kHalf = {16, 22, 30, 20, 24, 50, 80, 80, 70, 24, 12};
  AnsweredPerson p;
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    p.answer.measurements[m] = {kValues[m], kValues[m] - kHalf[m], kValues[m] + 1.1F * kHalf[m]};
  p.answer.female = 0.1F;
  p.answer.from = from;
  p.answer.clothed = clothed;
  p.age.years = {40, 20, 65};
  p.age.bands = {0.2F, 0.4F, 0.3F, 0.1F};
  return p;
}

float width(const index::IntervalEstimate& e) {
  return e.high - e.low;
}

class KnownFactsOf : public testing::TestWithParam<std::tuple<index::AnsweredFrom, bool>> {
 protected:
  AnsweredPerson before_ = answered_person(std::get<0>(GetParam()), std::get<1>(GetParam()));
};

INSTANTIATE_TEST_SUITE_P(EveryTable, KnownFactsOf,
                         testing::Combine(testing::Values(index::AnsweredFrom::fitted_front,
                                                          index::AnsweredFrom::front_and_back),
                                          testing::Bool()));

TEST_P(KnownFactsOf, NothingKnownChangesNoBit) {
  AnsweredPerson p = before_;
  const KnownOutcome outcome = condition({}, p.answer, p.age);
  EXPECT_EQ(outcome.used, 0U);
  EXPECT_EQ(outcome.doubted, 0U);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    EXPECT_EQ(p.answer.measurements[m].value, before_.answer.measurements[m].value);
    EXPECT_EQ(p.answer.measurements[m].low, before_.answer.measurements[m].low);
    EXPECT_EQ(p.answer.measurements[m].high, before_.answer.measurements[m].high);
  }
  EXPECT_EQ(p.answer.female, before_.answer.female);
}

TEST_P(KnownFactsOf, AHeavierWeightOnAScaleWidensTheWaistAndNarrowsItsInterval) {
  AnsweredPerson p = before_;
  KnownFacts facts;
  facts.weight_kg = {84, kScaleSdKg};
  const KnownOutcome outcome = condition(facts, p.answer, p.age);
  EXPECT_EQ(outcome.used, bit_of(KnownFact::weight));
  EXPECT_NEAR(p.answer.measurements[kWeight].value, 84, 0.5);
  EXPECT_NEAR(width(p.answer.measurements[kWeight]) / 2, 2 * kScaleSdKg, 0.5);
  EXPECT_GT(p.answer.measurements[kWaist].value, before_.answer.measurements[kWaist].value + 8);
  EXPECT_LT(width(p.answer.measurements[kWaist]), 0.95F * width(before_.answer.measurements[kWaist]));
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    EXPECT_LE(width(p.answer.measurements[m]), width(before_.answer.measurements[m]) * 1.0001F);
}

TEST_P(KnownFactsOf, AWeightAsReportedMovesLessThanOneOnAScale) {
  AnsweredPerson scale = before_, stated = before_;
  KnownFacts facts;
  facts.weight_kg = {84, kScaleSdKg};
  condition(facts, scale.answer, scale.age);
  facts.weight_kg.sd = kStatedWeightSdKg;
  condition(facts, stated.answer, stated.age);
  const float off = before_.answer.measurements[kWaist].value;
  EXPECT_GT(stated.answer.measurements[kWaist].value, off);
  EXPECT_GT(scale.answer.measurements[kWaist].value, stated.answer.measurements[kWaist].value);
}

TEST_P(KnownFactsOf, ASlipOfUnitsIsDoubtedAndChangesNothing) {
  AnsweredPerson p = before_;
  KnownFacts facts;
  facts.weight_kg = {172, kStatedWeightSdKg};     // 78 kg in pounds
  facts.stature_mm = {1850, kStatedStatureSdMm};  // 100 mm too tall
  const KnownOutcome outcome = condition(facts, p.answer, p.age);
  EXPECT_EQ(outcome.used, 0U);
  EXPECT_EQ(outcome.doubted, bit_of(KnownFact::weight) | bit_of(KnownFact::stature));
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    EXPECT_FLOAT_EQ(p.answer.measurements[m].value, before_.answer.measurements[m].value);
}

TEST_P(KnownFactsOf, SexAndAgeAreTakenAsGiven) {
  AnsweredPerson p = before_;
  KnownFacts facts;
  facts.sex = KnownSex::woman;
  facts.age_years = {70.5F, kStatedAgeSdYears};
  const KnownOutcome outcome = condition(facts, p.answer, p.age);
  EXPECT_EQ(outcome.used, bit_of(KnownFact::sex) | bit_of(KnownFact::age));
  EXPECT_EQ(p.answer.female, 1.0F);
  EXPECT_EQ(p.age.years.value, 70.5F);
  EXPECT_EQ(p.age.bands, (std::array<float, kAgeBandCount>{0, 0, 0, 1}));
}

TEST_P(KnownFactsOf, TheValueStaysInsideItsInterval) {
  for (const float kg : {62.0F, 70.0F, 78.0F, 90.0F}) {
    AnsweredPerson p = before_;
    KnownFacts facts;
    facts.weight_kg = {kg, kScaleSdKg};
    facts.stature_mm = {1740, kStatedStatureSdMm};
    facts.sex = KnownSex::man;
    condition(facts, p.answer, p.age);
    for (const index::IntervalEstimate& e : p.answer.measurements) {
      EXPECT_LT(e.low, e.value);
      EXPECT_LT(e.value, e.high);
    }
  }
}

TEST(KnownFacts, WhatATurnMeasuredIsNotMovedByAWeight) {
  const AnsweredPerson before = answered_person(index::AnsweredFrom::around, false);
  AnsweredPerson p = before;
  KnownFacts facts;
  facts.weight_kg = {84, kScaleSdKg};
  const KnownOutcome outcome = condition(facts, p.answer, p.age);
  EXPECT_EQ(outcome.used, bit_of(KnownFact::weight));
  EXPECT_NEAR(p.answer.measurements[kWeight].value, 84, 0.5);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    if (m == kWeight) continue;
    EXPECT_EQ(p.answer.measurements[m].value, before.answer.measurements[m].value) << m;
    EXPECT_FLOAT_EQ(width(p.answer.measurements[m]), width(before.answer.measurements[m])) << m;
  }
}

TEST(KnownFacts, FactsOutOfRangeAreNamed) {
  KnownFacts facts;
  facts.stature_mm = {175, kStatedStatureSdMm};  // centimetres
  EXPECT_THAT(check_known(facts).error().message,
              AllOf(HasSubstr("known stature: expected 500 to 2500 mm"), Not(HasSubstr("175"))));
  facts = {};
  facts.weight_kg = {std::numeric_limits<float>::quiet_NaN(), 1};
  EXPECT_THAT(check_known(facts).error().message, HasSubstr("known weight"));
  facts.weight_kg = {80, -1};
  EXPECT_THAT(check_known(facts).error().message, HasSubstr("standard deviation"));
  facts = {};
  facts.age_years = {200, 1};
  EXPECT_THAT(check_known(facts).error().message, HasSubstr("0 to 120 years"));
  facts.age_years = {40, 20};  // answers nothing
  EXPECT_THAT(check_known(facts).error().message, HasSubstr("0.1 to 5 years"));
  EXPECT_TRUE(check_known({}));
}

}  // namespace
}  // namespace im2fit
