// SPDX-License-Identifier: Apache-2.0
// A site's statistics against values worked out by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/study/calibrate.h"
#include "evaluation/study/site_report.h"
#include "evaluation/study/site_statistics.h"

namespace im2fit::lab {
namespace {

constexpr auto kStature = measurement_index(Measurement::stature);
constexpr auto kWaist = measurement_index(Measurement::waist_girth);

SitePerson person(const std::string& name, double answer, double first, double second = kNoValue) {
  SitePerson p;
  p.person = name;
  p.answer.fill({1000, 900, 1100});
  const auto value = static_cast<float>(answer);
  p.answer[kWaist] = {value, value - 10, value + 10};
  p.tape[kWaist] = {first, second};
  return p;
}

TEST(Study, BiasMaeSdAndAgreementByHand) {
  // Errors: +4, -2, +6, 0: mean 2, SD sqrt(40/3).
  const SiteStudy study =
      study_of({person("a", 804, 800), person("b", 798, 800), person("c", 806, 800), person("d", 800, 800)});
  const MeasurementStudy& m = study.measurements[kWaist];
  const double sd = std::sqrt(40.0 / 3);
  EXPECT_EQ(m.errors.count, 4);
  EXPECT_DOUBLE_EQ(m.errors.bias, 2);
  EXPECT_DOUBLE_EQ(m.as_taken.mae, 3);
  EXPECT_NEAR(m.as_taken.sd, sd, 1e-12);
  EXPECT_NEAR(m.as_taken.agreement_low, 2 - 1.96 * sd, 1e-12);
  EXPECT_NEAR(m.as_taken.agreement_high, 2 + 1.96 * sd, 1e-12);
  EXPECT_EQ(m.as_taken.covered.hits, 4);
  EXPECT_FALSE(m.tape_known);
  EXPECT_EQ(study.measurements[kStature].errors.count, 0);
  // 2 + 1.96 * 3.65 / 2 = 5.58: within 9.
  EXPECT_TRUE(m.within);
  EXPECT_DOUBLE_EQ(m.interval_width, 20);
}

TEST(Study, AShareHasWilsonsInterval) {
  // 8 of 10: (0.8 + 0.19208 -+ 1.96 sqrt(0.016 + 0.009604)) / 1.38416.
  const Share share = share_of_count(8, 10);
  EXPECT_NEAR(share.low, (0.99208 - 1.96 * std::sqrt(0.025604)) / 1.38416, 1e-9);
  EXPECT_NEAR(share.high, (0.99208 + 1.96 * std::sqrt(0.025604)) / 1.38416, 1e-9);
  EXPECT_EQ(share_of_count(0, 10).low, 0);
  EXPECT_EQ(share_of_count(10, 10).high, 1);
  EXPECT_EQ(share_of_count(0, 0).count, 0);
}

TEST(Study, TheTapesOwnErrorIsTakenOut) {
  // Errors of means: +6, -6, three times each. Pairs differ by 4: TEM =
  // sqrt(16/2) = sqrt(8); a mean of two has 4 of variance. Variance of errors 216/5 = 43.2.
  std::vector<SitePerson> people;
  for (int i = 0; i < 6; ++i) people.push_back(person("p" + std::to_string(i), i % 2 == 0 ? 806 : 794, 798, 802));
  const MeasurementStudy m = study_of(people).measurements[kWaist];
  ASSERT_TRUE(m.tape_known);
  EXPECT_EQ(m.tape.pairs, 6);
  EXPECT_NEAR(m.tape.tem, std::sqrt(8.0), 1e-12);
  EXPECT_NEAR(m.as_taken.sd, std::sqrt(43.2), 1e-9);
  EXPECT_NEAR(m.tape_out.sd, std::sqrt(39.2), 1e-5);
  EXPECT_NEAR(m.tape_out.mae, 6 * std::sqrt(39.2 / 43.2), 1e-5);
  EXPECT_DOUBLE_EQ(m.errors.bias, 0);
}

TEST(Study, SaysHowManyPeopleAClaimNeeds) {
  EXPECT_EQ(people_for_claim(0, 4, 4), kIsoPeopleMin);
  // (1.96 * 20 / (9 - 4))^2 = 61.5.
  EXPECT_EQ(people_for_claim(-4, 20, 9), 62);
  EXPECT_EQ(people_for_claim(9, 1, 9), 0);
}

TEST(Study, GroupsSexSizeAndRepeatVisits) {
  std::vector<SitePerson> people = {person("a", 804, 800), person("b", 798, 800), person("a", 802, 800)};
  people[1].woman = true;
  people[1].female = 0.9;
  people[2].woman = false;
  people[2].female = 0.7;
  people[1].worn_size = people[1].answered_size = people[2].worn_size = "M";
  people[2].answered_size = "L";
  people[2].clothing = "loose";
  const SiteStudy study = study_of(people);
  EXPECT_EQ(study.visits, 3);
  EXPECT_EQ(study.people, 2);
  EXPECT_DOUBLE_EQ(study.measurements[kWaist].errors.bias, 0);  // -2 and the last visit's +2
  EXPECT_EQ(study.sex_right.hits, 1);
  EXPECT_EQ(study.sex_right.count, 2);
  EXPECT_EQ(study.size_right.hits, 1);
  std::vector<std::string> names;
  for (const StudyGroup& group : study.groups) names.push_back(group.name);
  EXPECT_THAT(names, testing::ElementsAre("women", "men", "loose clothes"));
  EXPECT_DOUBLE_EQ(study.groups[0].rows[kWaist].bias, -2);
}

TEST(Study, ReportsAreWholeAndWithoutAnythingFromElsewhere) {
  std::vector<SitePerson> people;
  for (int i = 0; i < 12; ++i) {
    people.push_back(person("p" + std::to_string(i), 800 + i, 800));
    people.back().tape[kStature].first = 1500 + 30 * i;
    people.back().answer[kStature] = {1504.0F + 30 * static_cast<float>(i), 1480, 1900};
    people.back().woman = i % 2 == 0;
  }
  const SiteStudy study = study_of(people);
  const std::string html = html_of(study, people, "Shop <3>", false);
  EXPECT_THAT(html, testing::HasSubstr("Shop &lt;3&gt;"));
  EXPECT_THAT(html, testing::Not(testing::HasSubstr("http")));
  EXPECT_THAT(html, testing::Not(testing::HasSubstr("<script")));
  EXPECT_THAT(html, testing::Not(testing::HasSubstr("nan")));
  EXPECT_THAT(html, testing::HasSubstr("Height is off by 4.0 mm"));
  const auto json = nlohmann::json::parse(json_of(study));
  EXPECT_EQ(json["schema"], "im2fit.study/1");
  EXPECT_DOUBLE_EQ(json["measurements"]["stature"]["bias"], 4);
  EXPECT_FALSE(json["measurements"].contains("hip_girth"));
  EXPECT_THAT(text_of(study), testing::HasSubstr("waist_girth"));
}

}  // namespace
}  // namespace im2fit::lab
