// SPDX-License-Identifier: Apache-2.0
// Refined answers in a world where it is known what each view adds.
#include "index/refinement.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>

#include "tests/index/refined_people.h"
#include "train/index/calibration.h"

namespace im2fit::index {
namespace {

using testing::kFreshSubjects;
using testing::kWaist;
using testing::options_for;
using testing::turned;
using testing::World;

std::vector<Sample> people(const World& world, bool with_turned) {
  std::vector<Sample> samples;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    samples.push_back(turned(world, i));
    if (with_turned && i % 2 == 0) continue;
    samples.back().fit.clear();
    samples.back().fit_both.clear();
    samples.back().back.clear();
  }
  return samples;
}

const Index& index_with(bool refinements) {
  const auto make = [](bool with_turned) {
    const World world;
    const auto samples = people(world, with_turned);
    return std::move(*Index::parse(*build_index(options_for(world), source_of(samples)), "refined"));
  };
  static const Index with = make(true), without = make(false);
  return refinements ? with : without;
}

Seen seen_of(const Sample& s) {
  return {s.feature, s.fit, s.back, s.fit_both};
}

TEST(Refinement, EachViewAddsWhatItShows) {
  const World world;
  const Index& index = index_with(true);
  EXPECT_EQ(index.fit_layout(), (FitLayout{static_cast<std::uint32_t>(world.shapes), 0, 0}));
  EXPECT_EQ(index.info().refined[0].sample_count, 1500U);
  auto scratch = index.make_scratch();
  double front = 0, fitted = 0, both = 0, spread = 0;
  const int count = 400;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Sample s = turned(world, kFreshSubjects + i);
    const auto error = [&](const Seen& seen, AnsweredFrom from) {
      const Answer a = *index.query(seen, {}, *scratch);
      EXPECT_EQ(a.from, from);
      return std::abs(static_cast<double>(a.measurements[kWaist].value - s.truth[kWaist])) / count;
    };
    front += error({s.feature, {}, {}, {}}, AnsweredFrom::front);
    fitted += error({s.feature, s.fit, {}, {}}, AnsweredFrom::fitted_front);
    both += error(seen_of(s), AnsweredFrom::front_and_back);
    spread += std::abs(static_cast<double>(s.truth[kWaist]) - 1000) / count;
  }
  EXPECT_LT(fitted, 0.97 * front);
  EXPECT_LT(both, 0.8 * fitted);
  EXPECT_LT(front, 0.2 * spread);
}

TEST(Refinement, IntervalsOfEachHoldTheTruthAsOftenAsTheySay) {
  const World world;
  const Index& index = index_with(true);
  auto scratch = index.make_scratch();
  int fitted = 0, both = 0;
  const int count = 1000;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Sample s = turned(world, kFreshSubjects + 5000 + i);
    QueryOptions options;
    options.frame_count = s.frame_count;
    const auto inside = [&](const Seen& seen) {
      const Answer a = *index.query(seen, options, *scratch);
      int hits = 0;
      for (std::size_t m = 0; m < kMeasurementCount; ++m)
        hits += s.truth[m] >= a.measurements[m].low && s.truth[m] <= a.measurements[m].high ? 1 : 0;
      return hits;
    };
    fitted += inside({s.feature, s.fit, {}, {}});
    both += inside(seen_of(s));
  }
  for (const int hits : {fitted, both}) {
    EXPECT_GT(hits, 0.93 * count * kMeasurementCount);
    EXPECT_LT(hits, 0.97 * count * kMeasurementCount);
  }
}

TEST(Refinement, IntervalsForUnknownMakesAreWiderByTheTable) {
  const World world;
  std::vector<Sample> samples;
  for (std::uint64_t i = 0; i < 600; ++i) samples.push_back(turned(world, i));
  BuildOptions options = options_for(world);
  const Index known = *Index::parse(*build_index(options, source_of(samples)), "known");
  options.for_unknown_makes = true;
  const Index unknown = *Index::parse(*build_index(options, source_of(samples)), "unknown");
  auto one = known.make_scratch(), other = unknown.make_scratch();
  const Sample s = turned(world, kFreshSubjects);
  const auto width = [](const IntervalEstimate& e) { return e.high - e.low; };
  for (const Refinement kind : {Refinement::fitted, Refinement::turned}) {
    Seen seen = seen_of(s);
    if (kind == Refinement::fitted) seen.back = seen.fit_both = {};
    const Answer a = *known.query(seen, {}, *one), b = *unknown.query(seen, {}, *other);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      EXPECT_EQ(a.measurements[m].value, b.measurements[m].value);
      EXPECT_NEAR(width(b.measurements[m]) / width(a.measurements[m]),
                  kUnknownMakeWidening[static_cast<std::size_t>(kind)][m], 1e-3);
    }
  }
}

TEST(Refinement, TheFrontsAnswerIsNotTouched) {
  const World world;
  auto with = index_with(true).make_scratch(), without = index_with(false).make_scratch();
  for (std::uint64_t i = 0; i < 50; ++i) {
    const Sample s = turned(world, kFreshSubjects + i);
    const Answer a = *index_with(true).query(s.feature, {}, *with);
    const Answer b = *index_with(false).query(seen_of(s), {}, *without);  // never learned to refine
    EXPECT_EQ(b.from, AnsweredFrom::front);
    EXPECT_EQ(std::memcmp(a.measurements.data(), b.measurements.data(), sizeof a.measurements), 0);
    EXPECT_EQ(a.nearest, b.nearest);
  }
}

TEST(Refinement, OtherSizesThanLearnedAreNotUsed) {
  const World world;
  const Index& index = index_with(true);
  auto scratch = index.make_scratch();
  Sample s = turned(world, kFreshSubjects);
  s.back.pop_back();
  EXPECT_EQ(index.query(seen_of(s), {}, *scratch)->from, AnsweredFrom::fitted_front);
  s.fit.push_back(0);
  EXPECT_EQ(index.query(seen_of(s), {}, *scratch)->from, AnsweredFrom::front);
}

// By shapes alone, and with the value of the patches or limbs that shows it.
void expect_used(std::uint32_t patches, std::uint32_t limbs, std::size_t shown_at) {
  const World world;
  const auto shapes_alone = [&](Sample& s) {
    for (auto* fit : {&s.fit, &s.fit_both}) fit->resize(static_cast<std::size_t>(world.shapes));
    s.fit_layout = {static_cast<std::uint32_t>(world.shapes), 0, 0};
  };
  const auto build = [&](bool with_views) {
    std::vector<Sample> samples;
    for (std::uint64_t i = 0; i < 1500; ++i) {
      samples.push_back(testing::turned_with_views(world, i, patches, limbs, shown_at));
      if (!with_views) shapes_alone(samples.back());
    }
    return std::move(*Index::parse(*build_index(options_for(world), source_of(samples)), "views"));
  };
  const Index with = build(true), without = build(false);
  EXPECT_EQ(with.fit_layout(), (FitLayout{static_cast<std::uint32_t>(world.shapes), patches, limbs}));
  auto scratch = with.make_scratch();
  auto plain = without.make_scratch();
  for (const bool back : {false, true}) {
    double with_mm = 0, without_mm = 0;
    const int count = 200;
    for (std::uint64_t i = 0; i < count; ++i) {
      Sample s = testing::turned_with_views(world, kFreshSubjects + i, patches, limbs, shown_at);
      const auto error = [&](const Index& index, Index::Scratch& work) {
        const Seen seen = back ? seen_of(s) : Seen{s.feature, s.fit, {}, {}};
        const Answer a = *index.query(seen, {}, work);
        EXPECT_EQ(a.from, back ? AnsweredFrom::front_and_back : AnsweredFrom::fitted_front);
        return std::abs(static_cast<double>(a.measurements[kWaist].value - s.truth[kWaist])) / count;
      };
      with_mm += error(with, *scratch);
      shapes_alone(s);
      without_mm += error(without, *plain);
    }
    EXPECT_LT(with_mm, 0.8 * without_mm) << back;
  }
}

TEST(Refinement, PatchesTellWhatShapesDoNot) {
  expect_used(4, 0, 0);
}

TEST(Refinement, LimbsTellWhatShapesDoNot) {
  expect_used(2, 3, 4);
}

// A capture in a pose of its own, which the feature of the front and the fits follow.
Sample posed(const World& world, std::uint64_t subject, std::uint64_t capture) {
  Sample s = turned(world, subject);
  Rng rng = Rng::for_item(41, capture, subject);
  const auto pose = static_cast<float>(rng.normal(0, 0.4));
  for (auto* values : {&s.feature, &s.fit, &s.fit_both})
    for (std::size_t i = 0; i < values->size(); i += 2) (*values)[i] += pose;
  s.again = capture > 0;
  return s;
}

TEST(Refinement, RepeatCapturesShowWhatThePoseChanges) {
  const World world;
  const auto build = [&](bool informed) {
    std::vector<Sample> samples;
    for (std::uint64_t i = 0; i < 1500; ++i)
      for (std::uint64_t capture = 0; capture < 2; ++capture) {
        samples.push_back(posed(world, i, capture));
        if (!informed && capture > 0) samples.back().subject += 10'000;  // of another person, as far as it knows
      }
    return std::move(*Index::parse(*build_index(options_for(world), source_of(samples)), "captures"));
  };
  const Index informed = build(true), uninformed = build(false);
  EXPECT_EQ(informed.size(), 1500U) << "who is seen again is no second entry";
  EXPECT_EQ(informed.info().refined[0].sample_count, 3000U);
  const auto differences_and_errors = [&](const Index& index) {
    auto scratch = index.make_scratch();
    std::array<double, 2> sums{};
    for (std::uint64_t i = 0; i < 400; ++i) {
      const Sample a = posed(world, kFreshSubjects + i, 0), b = posed(world, kFreshSubjects + i, 1);
      const float first = index.query({a.feature, a.fit, {}, {}}, {}, *scratch)->measurements[kWaist].value;
      const float second = index.query({b.feature, b.fit, {}, {}}, {}, *scratch)->measurements[kWaist].value;
      sums[0] += std::abs(static_cast<double>(first - second));
      sums[1] += std::abs(static_cast<double>(first - a.truth[kWaist]));
    }
    return sums;
  };
  const auto with = differences_and_errors(informed), without = differences_and_errors(uninformed);
  EXPECT_LT(with[0], 0.9 * without[0]);
  EXPECT_LT(with[1], 1.05 * without[1]);
}

TEST(Refinement, OutOfDistributionSubjectsAreTheShareGiven) {
  const auto which = ood_beside(900, 5000, 0.1);
  ASSERT_EQ(which.size(), 100U);
  for (std::size_t i = 0; i < which.size(); ++i) EXPECT_EQ(which[i], 50 * i);
  EXPECT_EQ(ood_beside(900, 60, 0.1).size(), 60U);  // all there are
  EXPECT_TRUE(ood_beside(0, 60, 0.1).empty());
  EXPECT_TRUE(ood_beside(900, 0, 0.1).empty());
}

TEST(Refinement, BuildingRefusesFitsOfAnotherLayout) {
  const World world;
  std::vector<Sample> samples;
  for (std::uint64_t i = 0; i < 20; ++i) samples.push_back(testing::turned_with_views(world, i, 4, 0, 0));
  samples[7].fit_layout.patches = 3;
  samples[7].fit_layout.limbs = 1;  // the same number of values
  EXPECT_NE(build_index(options_for(world), source_of(samples)).error().message.find("sample 7"), std::string::npos);
  samples[7].fit_layout = {samples[6].fit_layout.shapes, 100, 0};  // more than there are
  EXPECT_NE(build_index(options_for(world), source_of(samples)).error().message.find("sample 7"), std::string::npos);
}

TEST(Refinement, BuildingRefusesHalfOfATurnedSample) {
  const World world;
  auto samples = people(world, true);
  samples[10].back.pop_back();
  const auto built = build_index(options_for(world), source_of(samples));
  ASSERT_FALSE(built);
  EXPECT_NE(built.error().message.find("sample 10"), std::string::npos) << built.error().message;
}

}  // namespace
}  // namespace im2fit::index
