// SPDX-License-Identifier: Apache-2.0
// People in clothes: learned from samples of their own, answered apart.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/index/refined_people.h"

namespace im2fit::index {
namespace {

using testing::kFreshSubjects;
using testing::kWaist;
using testing::options_for;
using testing::turned;
using testing::World;

// Clothes add to all that is seen, by an ease that only each person's garments know: 2 standard deviations of shape,
// give or take 0.3. What is under them is the same.
Sample in_clothes(const World& world, std::uint64_t subject) {
  Sample s = turned(world, subject);
  Rng rng = Rng::for_item(7, 7, subject);
  const auto ease = static_cast<float>(2 + rng.normal(0, 0.3));
  for (auto* values : {&s.feature, &s.back})
    for (float& v : *values) v += ease;
  for (auto* fit : {&s.fit, &s.fit_both})
    for (int i = 0; i < world.shapes; ++i) (*fit)[static_cast<std::size_t>(i)] += ease;
  s.clothed = true;
  return s;
}

// Of every third person a sample in clothes follows the bare one, if wanted.
const Index& index_with(bool clothed) {
  const auto make = [](bool dressed) {
    const World world;
    std::vector<Sample> samples;
    for (std::uint64_t i = 0; i < 2400; ++i) {
      samples.push_back(turned(world, i));
      if (dressed && i % 3 == 0) samples.push_back(in_clothes(world, i));
    }
    return std::move(*Index::parse(*build_index(options_for(world), source_of(samples)), "clothed"));
  };
  static const Index with = make(true), without = make(false);
  return clothed ? with : without;
}

Seen seen_of(const Sample& s) {
  return {s.feature, s.fit, s.back, s.fit_both, s.clothed};
}

TEST(Clothed, TheBodyUnderneathIsAnswered) {
  const World world;
  const Index& index = index_with(true);
  ASSERT_TRUE(index.knows_clothed());
  EXPECT_EQ(index.size(), 2400U) << "no person in clothes is an entry";
  auto scratch = index.make_scratch();
  double informed = 0, uninformed = 0, both = 0;
  int inside = 0;
  const int count = 400;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Sample s = in_clothes(world, kFreshSubjects + i);
    Seen seen{s.feature, s.fit, {}, {}, true};
    const auto error = [&] {
      const Answer a = *index.query(seen, {}, *scratch);
      EXPECT_EQ(a.clothed, seen.clothed);
      return std::abs(static_cast<double>(a.measurements[kWaist].value - s.truth[kWaist])) / count;
    };
    informed += error();
    seen.clothed = false;
    uninformed += error();
    seen = seen_of(s);
    both += error();
    const Answer a = *index.query(seen, {}, *scratch);
    EXPECT_EQ(a.from, AnsweredFrom::front_and_back);
    inside += a.measurements[kWaist].low <= s.truth[kWaist] && s.truth[kWaist] <= a.measurements[kWaist].high ? 1 : 0;
  }
  EXPECT_LT(informed, 0.4 * uninformed);
  EXPECT_LT(both, informed);
  EXPECT_GT(inside, 0.91 * count);
}

TEST(Clothed, AnswersToPeopleUndressedStayTheSameBits) {
  const World world;
  auto with = index_with(true).make_scratch(), without = index_with(false).make_scratch();
  for (std::uint64_t i = 0; i < 50; ++i) {
    const Sample s = turned(world, kFreshSubjects + i);
    for (const Seen& seen : {Seen{s.feature, {}, {}, {}}, Seen{s.feature, s.fit, {}, {}}, seen_of(s)}) {
      const Answer a = *index_with(true).query(seen, {}, *with);
      const Answer b = *index_with(false).query(seen, {}, *without);
      EXPECT_EQ(std::memcmp(a.measurements.data(), b.measurements.data(), sizeof a.measurements), 0);
      EXPECT_EQ(a.nearest, b.nearest);
    }
  }
}

TEST(Clothed, AnIndexThatNeverSawClothesSaysSo) {
  const World world;
  const Index& index = index_with(false);
  EXPECT_FALSE(index.knows_clothed());
  auto scratch = index.make_scratch();
  EXPECT_FALSE(index.query(seen_of(in_clothes(world, kFreshSubjects)), {}, *scratch)->clothed);
}

}  // namespace
}  // namespace im2fit::index
