// SPDX-License-Identifier: Apache-2.0
// The figures of `eval`, worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "evaluation/measurements/conditions.h"
#include "evaluation/measurements/error_statistics.h"
#include "evaluation/measurements/report.h"

namespace im2fit::lab {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(ErrorStatistics, OfFourErrors) {
  const ErrorStatistics s = error_statistics({-2, 0, kNaN, 2, 4});
  EXPECT_EQ(s.count, 4);
  EXPECT_DOUBLE_EQ(s.bias, 1);
  EXPECT_DOUBLE_EQ(s.mae, 2);
  EXPECT_DOUBLE_EQ(s.sd, std::sqrt(20.0 / 3));
  EXPECT_DOUBLE_EQ(s.p95, 4);
  EXPECT_DOUBLE_EQ(s.mean_high - s.bias, 1.96 * std::sqrt(20.0 / 3) / 2);
}

// Two pairs: squared differences 16 and 4, so TEM = sqrt(20 / 4). The four values 100, 104, 200, 198 have mean 150.5
// and squares 2550.25 + 2162.25 + 2450.25 + 2256.25.
TEST(Repeatability, OfTwoPairs) {
  const Repeatability r = repeatability({{100, 104}, {200, 198}, {kNaN, 7}});
  EXPECT_EQ(r.pairs, 2);
  EXPECT_DOUBLE_EQ(r.tem, std::sqrt(5.0));
  EXPECT_DOUBLE_EQ(r.percent, 100 * std::sqrt(5.0) / 150.5);
  EXPECT_DOUBLE_EQ(r.reliability, 1 - 5.0 / (9419.0 / 3));
  EXPECT_EQ(repeatability({}).pairs, 0);
}

// Differences 1, 2, 3 at means 100, 110, 120: bias 2, SD 1, a tenth by mm.
TEST(Agreement, OfThreePairs) {
  const Agreement a = agreement({{100.5, 99.5}, {111, 109}, {121.5, 118.5}, {1, kNaN}});
  EXPECT_EQ(a.count, 3);
  EXPECT_DOUBLE_EQ(a.bias, 2);
  EXPECT_DOUBLE_EQ(a.low, 2 - 1.96);
  EXPECT_DOUBLE_EQ(a.high, 2 + 1.96);
  EXPECT_NEAR(a.slope, 0.1, 1e-12);
}

TEST(BoxStatistics, WhiskersEndWithinOneAndAHalfBoxes) {
  // Quartiles of 1..9 are 3, 5, 7; the box reaches -3 .. 13, so 14 is an outlier once it joins them.
  const BoxStatistics even = box_statistics({9, 1, 2, 8, 3, 7, 4, 6, 5});
  EXPECT_DOUBLE_EQ(even.quartile_1, 3);
  EXPECT_DOUBLE_EQ(even.median, 5);
  EXPECT_DOUBLE_EQ(even.quartile_3, 7);
  EXPECT_DOUBLE_EQ(even.low, 1);
  EXPECT_DOUBLE_EQ(even.high, 9);
  EXPECT_TRUE(even.outliers.empty());
  const BoxStatistics odd = box_statistics({1, 2, 3, 4, 5, 6, 7, 8, 9, 40, kNaN});
  EXPECT_EQ(odd.count, 10);
  EXPECT_EQ(odd.outliers, std::vector<double>{40});
  EXPECT_DOUBLE_EQ(odd.high, 9);
}

TEST(Quantile, LiesBetweenRanks) {
  EXPECT_DOUBLE_EQ(quantile({10, 20, 30, 40}, 0.5), 25);
  EXPECT_DOUBLE_EQ(quantile({10, 20, 30, 40}, 0.25), 17.5);
  EXPECT_DOUBLE_EQ(quantile({10}, 0.9), 10);
}

TEST(Conditions, AreWordsThatChangeOneThingEach) {
  EvaluationOptions base;
  base.frames = 17;
  const auto plain = condition_of("noise", base);
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->options.frames, 17);
  EXPECT_FALSE(plain->options.clothed);
  const auto both = condition_of("clothed+320", base);
  ASSERT_TRUE(both);
  EXPECT_TRUE(both->options.clothed);
  EXPECT_EQ(both->options.width, 320);
  EXPECT_EQ(both->options.height, 240);
  EXPECT_EQ(both->options.frames, 17);
  EXPECT_FALSE(condition_of("foggy", base));
  EXPECT_FALSE(condition_of("noise+", base));
  const auto smoothed = condition_of("smoothed+reported", base);
  ASSERT_TRUE(smoothed);
  EXPECT_TRUE(smoothed->options.smoothed && smoothed->options.sensor_reported);
  EXPECT_FALSE(plain->options.smoothed || plain->options.sensor_reported);
  const auto garments = condition_of("garments", base);
  ASSERT_TRUE(garments);
  EXPECT_TRUE(garments->options.clothed && garments->options.garments);
  EXPECT_FALSE(both->options.garments);
  for (const std::string& name : all_conditions()) EXPECT_TRUE(condition_of(name, base)) << name;
}

constexpr std::size_t kStature = measurement_index(Measurement::stature);
constexpr std::size_t kChest = measurement_index(Measurement::chest_girth);

// Measured `error` off the truth in everything, with an interval of `reach` to both sides.
Outcome outcome(float truth_mm, float error, float reach, bool woman = false) {
  Outcome o;
  o.measured = true;
  o.woman = woman;
  o.answer.female = woman ? 0.9F : 0.1F;
  o.paper.fill(std::numeric_limits<float>::quiet_NaN());
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    o.truth[m] = truth_mm;
    const float value = truth_mm + error;
    o.answer.measurements[m] = {value, value - reach, value + reach};
    o.answer.nearest_values[m] = truth_mm + 2 * error;
  }
  return o;
}

TEST(Report, CountsWhatItIsGiven) {
  std::vector<Outcome> outcomes = {outcome(1000, 10, 20), outcome(1000, -10, 20), outcome(1000, 30, 20)};
  outcomes[0].measured_again = true;
  outcomes[0].again.fill(1014);
  outcomes[1].paper[kStature] = 1100;
  Outcome refused;
  refused.guidance_seen = static_cast<GuidanceSet>(Guidance::too_far);
  outcomes.push_back(refused);
  const Report r = report_of(outcomes, "noise", "a room");
  EXPECT_EQ(r.subjects, 4);
  EXPECT_EQ(r.measured, 3);
  const MeasurementReport& stature = r.measurements[kStature];
  EXPECT_NEAR(stature.of(Estimator::ours).bias, 10, 1e-4);
  EXPECT_NEAR(stature.of(Estimator::nearest).bias, 20, 1e-4);
  EXPECT_EQ(stature.of(Estimator::paper).count, 1);
  EXPECT_NEAR(stature.of(Estimator::paper).mae, 100, 1e-4);
  EXPECT_EQ(stature.of(Estimator::raw).count, 0);
  EXPECT_NEAR(stature.coverage(), 2.0 / 3, 1e-9);
  // 10 off of 20 at 1.96 SD: inside from 0.98 SD on, so at 68 % (0.994) and not at 50 % (0.674); 30 off never.
  EXPECT_NEAR(stature.covered[0], 0, 1e-9);
  EXPECT_NEAR(stature.covered[1], 2.0 / 3, 1e-9);
  EXPECT_NEAR(stature.covered[5], 2.0 / 3, 1e-9);
  EXPECT_NEAR(stature.interval_width, 40, 1e-4);
  EXPECT_NEAR(stature.interval_width_median, 40, 1e-4);
  EXPECT_EQ(stature.repeatability.pairs, 1);
  EXPECT_NEAR(stature.repeatability.tem, std::sqrt(16.0 / 2), 1e-4);
  EXPECT_DOUBLE_EQ(r.sex_accuracy, 1);
  const auto steps = r.size_steps;
  EXPECT_EQ(steps[0] + steps[1] + steps[2] + steps[3] + steps[4], 3);
}

TEST(Report, CountsFactsUsedAndDoubted) {
  const KnownFactSet stature = bit_of(KnownFact::stature), weight = bit_of(KnownFact::weight);
  std::vector<Outcome> people(4, outcome(2000, 0, 10));
  people[0].known = {stature | weight, 0};
  people[1].known = {stature, weight};
  people[2].known = {0, stature | weight};
  people[3].known = {stature | weight, 0};
  people[3].measured = false;  // nobody whose answer could rest on it
  EXPECT_EQ(json_value_of(report_of(people, "noise+known-all"))["known"].dump(),
            R"({"stature":{"used":2,"doubted":1},"weight":{"used":1,"doubted":2}})");
  EXPECT_FALSE(json_value_of(report_of({outcome(2000, 0, 10)}, "noise")).contains("known"));
}

TEST(Report, MedianWidthOfIntervalsIsNotTheMean) {
  const Report r = report_of({outcome(1000, 0, 10), outcome(1000, 0, 20), outcome(1000, 0, 90)}, "noise");
  EXPECT_NEAR(r.measurements[kStature].interval_width, 80, 1e-4);
  EXPECT_NEAR(r.measurements[kStature].interval_width_median, 40, 1e-4);
}

TEST(Report, JsonNamesWhatItWasMeasuredWith) {
  Report r = report_of({outcome(1000, 10, 20)}, "noise", "", "ansur");
  r.with = {22, 13, 4000, 7, "abc1234"};
  const nlohmann::ordered_json json = json_value_of(r);
  EXPECT_EQ(json.at("family"), "ansur");
  EXPECT_EQ(json.at("subjects"), 1);
  EXPECT_EQ(json.at("measured_with").dump(),
            R"({"dataset_version":22,"index_format":13,"index_models":4000,"seed":7,"commit":"abc1234"})");
  EXPECT_NEAR(json.at("measurements").at("stature").at("interval_width_median").get<double>(), 40, 1e-4);
  r.with.dataset_version.reset();
  EXPECT_TRUE(json_value_of(r).at("measured_with").at("dataset_version").is_null());
}

// Six men of 2 m and BMI 20 to 30 and one woman: errors grow by 3 mm a unit.
TEST(Report, TellsWhoErrsHow) {
  std::vector<Outcome> outcomes;
  for (const float index : {28.0F, 20.0F, 22.0F, 26.0F, 24.0F, 30.0F}) {
    Outcome o = outcome(2000, 0, 10);
    o.truth[measurement_index(Measurement::weight)] = 4 * index;
    const float error = 3 * (index - 25);
    o.answer.measurements[kChest] = {2000 + error, 2000 + error - 10, 2000 + error + 10};
    outcomes.push_back(o);
  }
  outcomes.push_back(outcome(2000, 0, 10, true));
  outcomes.back().truth[measurement_index(Measurement::weight)] = 100;
  const Report r = report_of(outcomes, "noise", "", "ansur");
  ASSERT_EQ(r.groups.size(), 4U);
  EXPECT_EQ(r.groups[0].name, "men, BMI 20.0 to 22.0");
  EXPECT_EQ(r.groups[0].people, 2);
  EXPECT_NEAR(r.groups[0].rows[kChest].bias, -12, 1e-3);
  EXPECT_NEAR(r.groups[0].rows[kChest].mae, 12, 1e-3);
  EXPECT_NEAR(r.groups[0].rows[kChest].coverage, 0.5, 1e-9);  // 15 off and 9 off, of 10
  EXPECT_NEAR(r.groups[1].rows[kChest].bias, 0, 1e-3);
  EXPECT_NEAR(r.groups[1].rows[kChest].coverage, 1, 1e-9);
  EXPECT_EQ(r.groups[3].people, 1);
  EXPECT_NEAR(r.slopes[kChest].slope, 3, 1e-3);
  EXPECT_NEAR(r.slopes[kStature].slope, 0, 1e-3);
  EXPECT_EQ(title_of(r), "noise of ansur");
  // A mixed run says how either family fares.
  outcomes.front().family = PeopleFamily::ansur;
  const Report mixed = report_of(outcomes, "noise");
  ASSERT_EQ(mixed.groups.size(), 6U);
  EXPECT_EQ(mixed.groups[4].name, "all of ansur");
  EXPECT_EQ(mixed.groups[4].people, 1);
}

// Two of four have no true chest, none has a true inside leg: they count nowhere, neither as covered nor as missed.
TEST(Report, LeavesUnknownTruthsOut) {
  constexpr std::size_t kInsideLeg = measurement_index(Measurement::inside_leg);
  std::vector<Outcome> outcomes = {outcome(1000, 10, 20), outcome(1000, 30, 40), outcome(1000, -50, 20),
                                   outcome(1000, 70, 20)};
  for (Outcome& o : outcomes) o.truth[kInsideLeg] = std::numeric_limits<float>::quiet_NaN();
  for (const std::size_t i : {2U, 3U}) outcomes[i].truth[kChest] = std::numeric_limits<float>::quiet_NaN();
  outcomes[0].measured_again = true;
  outcomes[0].again.fill(1014);
  const Report r = report_of(outcomes, "noise", "", "other");
  const MeasurementReport& chest = r.measurements[kChest];
  EXPECT_EQ(chest.of(Estimator::ours).count, 2);
  EXPECT_NEAR(chest.of(Estimator::ours).bias, 20, 1e-4);
  EXPECT_NEAR(chest.coverage(), 1, 1e-9);
  EXPECT_NEAR(chest.interval_width, 60, 1e-4);
  EXPECT_EQ(chest.agreement.count, 2);
  EXPECT_NEAR(r.measurements[kStature].coverage(), 0.5, 1e-9);
  EXPECT_FALSE(r.measurements[kInsideLeg].judged());
  EXPECT_EQ(r.measurements[kInsideLeg].repeatability.pairs, 1);
  // Nine measurements of 50 % and one of 100 %.
  EXPECT_NEAR(mean_coverage(r), (9 * 0.5 + 1) / 10, 1e-9);
  EXPECT_EQ(r.size_steps[0] + r.size_steps[1] + r.size_steps[2] + r.size_steps[3] + r.size_steps[4], 2);
  int chests = 0;
  for (const GroupReport& group : r.groups) {
    chests += group.rows[kChest].people;
    EXPECT_EQ(group.rows[kInsideLeg].people, 0);
    EXPECT_TRUE(std::isfinite(group.rows[kChest].bias));
    EXPECT_TRUE(std::isfinite(group.rows[kInsideLeg].mae));
  }
  EXPECT_EQ(chests, 2);
  EXPECT_EQ(r.slopes[kInsideLeg].slope, 0);
  const nlohmann::ordered_json json = json_value_of(r);
  const auto& leg = json.at("measurements").at("inside_leg");
  for (const char* figure : {"ours", "coverage_95", "interval_width_median", "agreement", "error_by_bmi"})
    EXPECT_TRUE(leg.at(figure).is_null()) << figure;
  EXPECT_EQ(json.at("measurements").at("chest_girth").at("ours").at("count"), 2);
  EXPECT_EQ(json.dump().find("nan"), std::string::npos);
  EXPECT_EQ(text_of(r).find("nan"), std::string::npos) << text_of(r);
  const std::vector<ConditionRun> runs = {{Condition{}, outcomes, r}};
  EXPECT_EQ(people_csv_of(runs).find("nan"), std::string::npos);
  EXPECT_EQ(csv_of(runs).find("nan"), std::string::npos);
}

TEST(Conditions, OfTheFamilyOtherAreBareAndNotHeavy) {
  EvaluationOptions base;
  for (const char* word : {"noise", "both", "tof", "arms_out", "back", "frames5+320"}) {
    auto condition = condition_of(word, base);
    ASSERT_TRUE(condition);
    condition->options.family = PeopleFamily::other;
    EXPECT_TRUE(shown_by_family(*condition)) << word;
  }
  for (const char* word : {"clothed", "garments", "clothed+320", "heavy"}) {
    auto condition = condition_of(word, base);
    ASSERT_TRUE(condition);
    EXPECT_TRUE(shown_by_family(*condition)) << word;
    condition->options.family = PeopleFamily::other;
    const Status shown = shown_by_family(*condition);
    ASSERT_FALSE(shown) << word;
    EXPECT_NE(shown.error().message.find(std::string("'") + word + "'"), std::string::npos) << shown.error().message;
    EXPECT_NE(shown.error().message.find("other"), std::string::npos) << shown.error().message;
  }
}

// EN 13402-3 men: M 94 to 102 cm.
TEST(Report, SizesAreLabelsOffTheTrueOne) {
  std::vector<Outcome> outcomes = {outcome(1000, 0, 5), outcome(1000, 40, 5), outcome(1000, -300, 5)};
  const Report r = report_of(outcomes, "noise");
  EXPECT_EQ(r.size_steps, (std::array<int, 5>{1, 0, 1, 1, 0}));
  EXPECT_NEAR(r.size_accuracy, 1.0 / 3, 1e-9);
  EXPECT_EQ(outcomes[0].truth[kChest], 1000);
}

}  // namespace
}  // namespace im2fit::lab
