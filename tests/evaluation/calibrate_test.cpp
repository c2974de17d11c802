// SPDX-License-Identifier: Apache-2.0
// Calibrations of simulated errors: people who had no part in one are answered better, and a site that needs none
// gets none.
#include "evaluation/study/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.h"
#include "evaluation/study/calibration_trials.h"

namespace im2fit::lab {
namespace {

constexpr auto kStature = measurement_index(Measurement::stature);
constexpr auto kWaist = measurement_index(Measurement::waist_girth);

struct Bias {
  double scale = 1, waist_mm = 0, noise = 1;
};

// Truths about 1000 mm, 80 kg; errors of 10 mm (2 kg) of which half is shared by all of a person.
std::vector<SitePerson> people(int count, const Bias& bias, std::uint64_t seed) {
  std::vector<SitePerson> all;
  for (int i = 0; i < count; ++i) {
    Rng rng = Rng::for_item(seed, 1, static_cast<std::uint64_t>(i));
    SitePerson p;
    p.person = std::to_string(i);
    p.woman = i % 2 == 0;
    p.female = *p.woman ? 0.98 : 0.02;
    p.camera = i % 3 == 0 ? "left" : "right";
    const double build = rng.normal(), common = rng.normal();
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const bool weight = kMeasurementTable[m].unit == "kg";
      const double unit = weight ? 2 : 10;
      const double truth = (weight ? 80 : 1000) + 8 * unit * build;
      double answer = truth + bias.noise * unit * std::sqrt(0.5) * (common + rng.normal());
      answer *= weight ? std::pow(bias.scale, 3) : bias.scale;
      if (m == kWaist) answer += bias.waist_mm;
      const auto value = static_cast<float>(answer);
      p.answer[m] = {value, value - 1.96F * static_cast<float>(unit), value + 1.96F * static_cast<float>(unit)};
      p.tape[m].first = truth;
    }
    all.push_back(p);
  }
  return all;
}

TEST(Calibrate, ACamerasScaleIsFoundFromTwentyPeople) {
  const CalibrationOutcome outcome = calibrate(people(20, {1.03, 0, 1}, 7));
  ASSERT_EQ(outcome.refusal, "");
  EXPECT_TRUE(outcome.values);
  EXPECT_GT(outcome.gain, 3 * outcome.gain_se);
  const std::vector<SitePerson> fresh = people(200, {1.03, 0, 1}, 8);
  double before = 0, after = 0;
  for (const SitePerson& p : fresh) {
    before += p.error(kStature) / 200;
    after += (static_cast<double>(corrected(outcome.model, p, kStature, true).value) - p.tape[kStature].mean()) / 200;
  }
  EXPECT_GT(before, 25);
  EXPECT_LT(std::abs(after), 0.4 * before);
}

TEST(Calibrate, TheDeviceCorrectsAsTheModelDoes) {
  const CalibrationOutcome outcome = calibrate(people(30, {1.02, 30, 1.5}, 9));
  ASSERT_EQ(outcome.refusal, "");
  const SiteCalibration site = site_calibration(outcome, "Shop", 5);
  const auto bytes = site.file();
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto read = SiteCalibration::parse(*bytes, "shop");
  ASSERT_TRUE(read) << read.error().message;
  for (const SitePerson& p : people(5, {1.02, 30, 1.5}, 10)) {
    index::Answer answer;
    answer.measurements = p.answer;
    answer.female = static_cast<float>(p.female);
    read->for_camera(p.camera).apply(answer);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const index::IntervalEstimate e = corrected(outcome.model, p, m, true);
      EXPECT_NEAR(answer.measurements[m].value, e.value, 1e-3) << m;
      EXPECT_NEAR(answer.measurements[m].low, e.low, 1e-3) << m;
      EXPECT_NEAR(answer.measurements[m].high, e.high, 1e-3) << m;
    }
  }
}

TEST(Calibrate, WhatItDoesToFreshPeople) {
  const std::vector<SitePerson> scaled = people(300, {1.03, 0, 1}, 11), tape = people(300, {1, 40, 1}, 12),
                                plain = without_bias(people(300, {1, 0, 1}, 13));
  const CalibrationTrial camera = try_calibrations("camera", scaled, 20, 4, 1);
  EXPECT_GT(camera.bias_off_median, 0.8);
  EXPECT_GT(camera.coverage_after, 0.93);
  EXPECT_LT(camera.coverage_before, 0.5);
  const CalibrationTrial waist = try_calibrations("tape", tape, 20, 4, 1);
  EXPECT_GT(waist.bias_off_median, 0.5);
  const CalibrationTrial none = try_calibrations("no bias", plain, 20, 6, 1);
  EXPECT_LT(none.mae_change_worst, 0.02);
}

TEST(Calibrate, NarrowOrWideIntervalsAreSetRight) {
  const CalibrationTrial wide = try_calibrations("wide", people(300, {1, 0, 2}, 14), 40, 3, 1);
  EXPECT_LT(wide.coverage_before, 0.8);
  EXPECT_GT(wide.coverage_after, 0.92);
  EXPECT_LT(wide.coverage_after, 0.98);
}

TEST(Calibrate, RefusesTooFewAndWhatDoesNotHelp) {
  EXPECT_THAT(calibrate(people(9, {1.03, 0, 1}, 15)).refusal, testing::HasSubstr("9 people"));
  EXPECT_THAT(calibrate({}).refusal, testing::HasSubstr("too few"));
  std::vector<SitePerson> untaken = people(20, {1.03, 0, 1}, 16);
  for (std::size_t i = 0; i < untaken.size(); ++i)
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      if (m % 4 != i % 4) untaken[i].tape[m] = {};  // five people a measurement
  EXPECT_THAT(calibrate(untaken).refusal, testing::HasSubstr("no measurement"));
  int refused = 0;
  for (std::uint64_t seed = 20; seed < 26; ++seed) {
    const CalibrationOutcome outcome = calibrate(without_bias(people(20, {}, seed)));
    refused += outcome.refusal.empty() ? 0 : 1;
    if (outcome.refusal.empty()) continue;
    EXPECT_THAT(outcome.refusal, testing::HasSubstr("would not help"));
  }
  EXPECT_GE(refused, 2);
}

TEST(Calibrate, ASlipOfThePenIsLeftAside) {
  std::vector<SitePerson> all = people(20, {1.03, 0, 1}, 17);
  all[4].tape[kWaist].first = 100;  // cm for mm
  const CalibrationOutcome outcome = calibrate(all);
  ASSERT_EQ(outcome.left_aside.size(), 1U);
  EXPECT_THAT(outcome.left_aside[0], testing::StartsWith("4: waist_girth 100.0"));
  EXPECT_EQ(outcome.model.rows[kWaist].people, 19);
}

TEST(Calibrate, MeasurementsWithoutATapeAreLeftAlone) {
  std::vector<SitePerson> all = people(20, {1.03, 0, 1}, 18);
  for (SitePerson& p : all)
    for (std::size_t m = 1; m < kMeasurementCount; ++m) p.tape[m] = {};
  const CalibrationOutcome outcome = calibrate(all);
  ASSERT_EQ(outcome.refusal, "");
  const SiteCalibration site = site_calibration(outcome, "heights", 0);
  EXPECT_EQ(site.row_people[kStature], 20U);
  EXPECT_EQ(site.row_people[kWaist], 0U);
  EXPECT_EQ(site.rows[kWaist].scale, 1);
  EXPECT_TRUE(site.file());
}

}  // namespace
}  // namespace im2fit::lab
