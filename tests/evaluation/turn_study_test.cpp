// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/turn_study.h"

#include <cmath>

#include "tests/train/tracker_fixture.h"

namespace im2fit::lab {
namespace {

class TurnStudy : public WithTracker {
 protected:
  static TurnStudyOptions two_people() {
    TurnStudyOptions options;
    options.people.subjects = 2;
    options.people.noise = false;
    options.people.pose = StandingPose::arms_out;
    options.seconds_min = options.seconds_max = 6;
    return options;
  }
};

TEST_F(TurnStudy, PeopleAreFollowedAndMeasured) {
  if (model().shape_space().point_count == 0) GTEST_SKIP() << "the body file has no shape space: im2fit-lab fetch";
  const auto outcomes = study_turns(model(), tracker(), two_people());
  ASSERT_TRUE(outcomes) << outcomes.error().message;
  ASSERT_EQ(outcomes->size(), 2U);
  for (const TurnOutcome& o : *outcomes) {
    ASSERT_TRUE(o.measured);
    EXPECT_NEAR(std::fabs(o.true_turn_deg), 360, 0.1);
    EXPECT_NEAR(o.turned_deg, o.true_turn_deg, 8);
    EXPECT_EQ(o.views_deg.size(), 8U);
    for (const Measurement m : {Measurement::waist_girth, Measurement::hip_girth})
      EXPECT_NEAR(o.measured_values[measurement_index(m)], o.truth[measurement_index(m)], 40);
  }
  EXPECT_NE(text_of(*outcomes).find("2 people, 2 fronts fitted, 2 measured"), std::string::npos);
}

TEST_F(TurnStudy, ThreadsDoNotChangeTheResult) {
  if (model().shape_space().point_count == 0) GTEST_SKIP() << "the body file has no shape space: im2fit-lab fetch";
  TurnStudyOptions options = two_people();
  options.degrees = 90;
  options.view_count = 3;
  const auto one = study_turns(model(), tracker(), options);
  options.people.threads = 2;
  const auto two = study_turns(model(), tracker(), options);
  ASSERT_TRUE(one && two);
  for (std::size_t i = 0; i < one->size(); ++i) {
    EXPECT_EQ((*one)[i].turned_deg, (*two)[i].turned_deg);
    EXPECT_EQ((*one)[i].measured_values, (*two)[i].measured_values);
  }
}

TEST(TurnStudyText, SaysHowManyWereMeasured) {
  TurnOutcome missed, measured;
  measured.front_found = measured.measured = true;
  measured.truth.fill(100);
  measured.measured_values.fill(103);
  measured.true_limbs.fill(500);
  measured.fused_limbs.fill(504);
  measured.answered_limbs.fill(490);
  const std::string text = text_of({missed, measured});
  EXPECT_NE(text.find("2 people, 1 fronts fitted, 1 measured"), std::string::npos);
  EXPECT_NE(text.find("waist_girth                      1     3.0     3.0     3.0"), std::string::npos) << text;
  EXPECT_NE(text.find("calf_girth                       1     4.0     4.0     4.0"), std::string::npos) << text;
  EXPECT_NE(text.find("calf_girth, one body             1   -10.0    10.0    10.0"), std::string::npos) << text;
  EXPECT_EQ(text.find("at true height"), std::string::npos);
  measured.has_levels = true;
  measured.at_true_level_mm = {1, 2, -5};
  EXPECT_NE(text_of({measured}).find("hip at true height               1    -5.0     5.0     5.0"),
            std::string::npos);
}

}  // namespace
}  // namespace im2fit::lab
