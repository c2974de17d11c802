// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/visit.h"

#include <gtest/gtest.h>

#include <set>

namespace im2fit::apps {
namespace {

using std::chrono::seconds;

class Visits : public testing::Test {
 protected:
  Visit::Time now_{};
  Visit visit_{VisitRules{}, now_};
};

TEST_F(Visits, GoFromConsentToResultAndAreForgotten) {
  const std::string first = visit_.id();
  EXPECT_EQ(visit_.state(), VisitState::asking);
  EXPECT_FALSE(visit_.measured(now_)) << "without consent";
  EXPECT_TRUE(visit_.consent(first, now_));
  EXPECT_FALSE(visit_.consent(first, now_)) << "once";
  EXPECT_TRUE(visit_.measured(now_));
  EXPECT_FALSE(visit_.measured(now_)) << "one result a visit";
  EXPECT_TRUE(visit_.erase(first, now_));
  EXPECT_EQ(visit_.state(), VisitState::asking);
  EXPECT_NE(visit_.id(), first);
  EXPECT_EQ(visit_.number(), 2U);
}

// A page that still shows the visit before.
TEST_F(Visits, AnotherIdDoesNothing) {
  const std::string old = visit_.id();
  ASSERT_TRUE(visit_.next(now_));
  EXPECT_FALSE(visit_.consent(old, now_));
  EXPECT_FALSE(visit_.consent("", now_));
  EXPECT_FALSE(visit_.erase(old, now_));
  EXPECT_FALSE(visit_.touch(old, now_));
  EXPECT_EQ(visit_.state(), VisitState::asking);
  EXPECT_EQ(visit_.number(), 2U);
}

TEST_F(Visits, AResultGoesTwoMinutesAfterTheLastTouch) {
  visit_.consent(visit_.id(), now_);
  visit_.measured(now_);
  EXPECT_FALSE(visit_.tick(now_ + seconds(119)));
  EXPECT_TRUE(visit_.touch(visit_.id(), now_ + seconds(119)));
  EXPECT_FALSE(visit_.tick(now_ + seconds(238)));
  EXPECT_EQ(visit_.left(now_ + seconds(238)), seconds(1));
  visit_.person_in_view(now_ + seconds(238));  // a person in view does not count as a touch
  EXPECT_TRUE(visit_.tick(now_ + seconds(239)));
  EXPECT_EQ(visit_.state(), VisitState::asking);
}

TEST_F(Visits, ConsentDoesNotOutliveItsPerson) {
  visit_.consent(visit_.id(), now_);
  visit_.person_in_view(now_ + seconds(20));
  EXPECT_FALSE(visit_.tick(now_ + seconds(49)));
  EXPECT_TRUE(visit_.tick(now_ + seconds(50)));
  EXPECT_EQ(visit_.state(), VisitState::asking);
}

TEST_F(Visits, AskingLastsAndWithoutAQuestionMeasuringDoes) {
  EXPECT_FALSE(visit_.tick(now_ + seconds(100'000)));
  EXPECT_EQ(visit_.left(now_), seconds(0));
  VisitRules rules;
  rules.ask = false;
  Visit open(rules, now_);
  EXPECT_EQ(open.state(), VisitState::measuring);
  EXPECT_FALSE(open.tick(now_ + seconds(100'000)));
  EXPECT_TRUE(open.measured(now_));
  EXPECT_TRUE(open.tick(now_ + seconds(120)));
  EXPECT_EQ(open.state(), VisitState::measuring);
}

// Whoever is asked for facts is not measured before they have answered, and goes as a result does.
TEST_F(Visits, FactsStandBetweenConsentAndMeasuring) {
  VisitRules rules;
  rules.ask_facts = true;
  Visit asking(rules, now_);
  EXPECT_FALSE(asking.facts_done(now_)) << "before consent";
  EXPECT_TRUE(asking.consent(asking.id(), now_));
  EXPECT_EQ(asking.state(), VisitState::facts);
  EXPECT_EQ(name_of(asking.state()), "FACTS");
  EXPECT_FALSE(asking.measured(now_));
  asking.person_in_view(now_ + seconds(110));
  EXPECT_EQ(asking.left(now_ + seconds(110)), seconds(10)) << "only a touch puts its end off";
  EXPECT_TRUE(asking.touch(asking.id(), now_ + seconds(110)));
  EXPECT_FALSE(asking.tick(now_ + seconds(229)));
  EXPECT_TRUE(asking.facts_done(now_ + seconds(229)));
  EXPECT_EQ(asking.state(), VisitState::measuring);
  EXPECT_FALSE(asking.facts_done(now_ + seconds(229))) << "once";
  EXPECT_FALSE(asking.tick(now_ + seconds(258)));
  EXPECT_TRUE(asking.tick(now_ + seconds(259)));
  EXPECT_TRUE(asking.consent(asking.id(), now_));
  EXPECT_TRUE(asking.tick(now_ + seconds(120)));
  EXPECT_EQ(asking.state(), VisitState::asking);
}

TEST(VisitIds, AreLongAndDiffer) {
  std::set<std::string> seen;
  for (int i = 0; i < 200; ++i) {
    const std::string id = random_id();
    EXPECT_EQ(id.size(), 32U);
    EXPECT_EQ(id.find_first_not_of("0123456789abcdef"), std::string::npos) << id;
    seen.insert(id);
  }
  EXPECT_EQ(seen.size(), 200U);
}

}  // namespace
}  // namespace im2fit::apps
