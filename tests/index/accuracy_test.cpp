// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/index/synthetic_people.h"
#include "train/index/raw_nearest.h"

namespace im2fit::index {
namespace {

using testing::build;
using testing::kFreshSubjects;
using testing::World;

// 3,000 subjects seen twice; shared, because building is the slow part.
const Index& straight_index() {
  static const Index index = std::move(*Index::parse(build(World(), 3000, 2), "straight"));
  return index;
}

double mean_error(const MeasurementValues& a, const MeasurementValues& b) {
  double sum = 0;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) sum += std::abs(static_cast<double>(a[m] - b[m]));
  return sum / kMeasurementCount;
}

MeasurementValues values_of(const Answer& a) {
  MeasurementValues out{};
  for (std::size_t m = 0; m < kMeasurementCount; ++m) out[m] = a.measurements[m].value;
  return out;
}

TEST(IndexAccuracy, ComesCloseToTheBestPossibleAnswerAndLeavesRawNearestFarBehind) {
  const World world;
  const Index& index = straight_index();
  RawNearest raw(static_cast<std::size_t>(world.features));
  for (std::uint64_t s = 0; s < 3000; ++s) ASSERT_TRUE(raw.add(world.sample(s, 0)));
  auto scratch = index.make_scratch();
  double ours = 0, best = 0, nearest = 0, entry = 0;
  int sex_right = 0;
  const int count = 300;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Sample q = world.sample(kFreshSubjects + i, 0);
    const Answer a = *index.query(q.feature, {}, *scratch);
    ours += mean_error(values_of(a), q.truth) / count;
    entry += mean_error(a.nearest_values, q.truth) / count;
    best += mean_error(world.best_answer(q), q.truth) / count;
    nearest += mean_error(raw.nearest(q.feature).values, q.truth) / count;
    sex_right += (a.female > 0.5F) == q.woman ? 1 : 0;
  }
  EXPECT_LT(ours, 1.1 * best) << "best possible " << best;
  EXPECT_LT(3 * ours, nearest);
  EXPECT_LT(entry, nearest);
  EXPECT_GT(sex_right, 0.92 * count);
}

TEST(IndexAccuracy, IntervalsHoldTheTruthAsOftenAsTheySay) {
  const World world;
  const Index& index = straight_index();
  auto scratch = index.make_scratch();
  int inside = 0;
  const int count = 1500;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Sample q = world.sample(kFreshSubjects + 5000 + i, 3);
    const Answer a = *index.query(q.feature, {}, *scratch);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      ASSERT_LE(a.measurements[m].low, a.measurements[m].value);
      ASSERT_GE(a.measurements[m].high, a.measurements[m].value);
      inside += q.truth[m] >= a.measurements[m].low && q.truth[m] <= a.measurements[m].high ? 1 : 0;
    }
  }
  const double coverage = inside / (count * static_cast<double>(kMeasurementCount));
  EXPECT_GT(coverage, 0.93);
  EXPECT_LT(coverage, 0.97);
}

TEST(IndexAccuracy, FewerFramesWidenTheIntervalWhereFramesWereSeenToMatter) {
  const World world;
  const auto index = Index::parse(build(world, 2000, 1, true), "frames");
  ASSERT_TRUE(index);
  auto scratch = index->make_scratch();
  int covered_few = 0, covered_many = 0;
  const int count = 600;
  for (std::uint64_t i = 0; i < count; ++i) {
    for (const int frames : {2, 14}) {
      const Sample q = world.sample(kFreshSubjects + i, static_cast<std::uint64_t>(frames), frames);
      const Answer a = *index->query(q.feature, {.frame_count = frames}, *scratch);
      for (std::size_t m = 0; m < kMeasurementCount; ++m)
        (frames == 2 ? covered_few : covered_many) +=
            q.truth[m] >= a.measurements[m].low && q.truth[m] <= a.measurements[m].high ? 1 : 0;
    }
  }
  const Sample q = world.sample(kFreshSubjects, 0);
  const Answer one = *index->query(q.feature, {.frame_count = 1}, *scratch);
  const Answer many = *index->query(q.feature, {.frame_count = 30}, *scratch);
  EXPECT_GT(one.measurements[0].high - one.measurements[0].low,
            1.1F * (many.measurements[0].high - many.measurements[0].low));
  const double total = count * static_cast<double>(kMeasurementCount);
  EXPECT_NEAR(covered_few / total, 0.95, 0.03);
  EXPECT_NEAR(covered_many / total, 0.95, 0.03);
}

// Out-of-distribution subjects differ from the index' people by more than the features show: the intervals must then
// hold for a mixture of which they are a sixth, and nothing else may change.
TEST(IndexAccuracy, OutOfDistributionSubjectsWidenTheIntervalsAndNothingElse) {
  const World world;
  const auto ood_subject = [&](std::uint64_t subject) {
    Sample s = world.sample(subject, 0);
    Rng rng = Rng::for_item(9, 9, subject);
    for (float& v : s.truth) v += static_cast<float>(rng.normal(0, 60));
    s.calibrate_only = true;
    return s;
  };
  std::vector<Sample> plain, wary;
  for (std::uint64_t s = 0; s < 500; ++s) {
    plain.push_back(world.sample(s, 0));
    wary.push_back(world.sample(s, 0));
    wary.push_back(ood_subject(kFreshSubjects + s));
  }
  const auto a = Index::parse(*build_index(testing::options_for(world), source_of(plain)), "plain");
  const auto b = Index::parse(*build_index(testing::options_for(world), source_of(wary)), "wary");
  ASSERT_TRUE(a && b);
  EXPECT_EQ(b->size(), 500U);
  auto scratch = a->make_scratch();
  constexpr std::uint64_t kQueried = 600, kOodQueried = 360;  // kOodShare
  int inside = 0;
  for (std::uint64_t i = 0; i < kQueried; ++i) {
    const Sample q = i < kOodQueried ? ood_subject(2 * kFreshSubjects + i) : world.sample(2 * kFreshSubjects + i, 0);
    const Answer x = *a->query(q.feature, {}, *scratch);
    const Answer y = *b->query(q.feature, {}, *scratch);
    EXPECT_EQ(x.nearest, y.nearest);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      EXPECT_EQ(x.measurements[m].value, y.measurements[m].value);
      inside += q.truth[m] >= y.measurements[m].low && q.truth[m] <= y.measurements[m].high ? 1 : 0;
    }
  }
  EXPECT_NEAR(inside / static_cast<double>(kQueried * kMeasurementCount), 0.95, 0.025);
}

TEST(IndexAccuracy, CorrectsWhatALinearMapCannot) {
  const World world(0.15);
  const auto index = Index::parse(build(world, 4000, 1), "bent");
  ASSERT_TRUE(index);
  EXPECT_NE(index->info().method, "ridge");
  double ridge = 0, answer = 0;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    ridge += static_cast<double>(index->info().ridge_mae[m]);
    answer += static_cast<double>(index->info().answer_mae[m]);
  }
  EXPECT_LT(answer, 0.9 * ridge);
  // The coverage stated in the file must hold for people it never saw.
  auto scratch = index->make_scratch();
  double fresh = 0;
  const int count = 400;
  for (std::uint64_t i = 0; i < count; ++i) {
    const Sample q = world.sample(kFreshSubjects + i, 0);
    fresh += mean_error(values_of(*index->query(q.feature, {}, *scratch)), q.truth) / count;
  }
  EXPECT_NEAR(fresh, answer / kMeasurementCount, 0.1 * fresh);
}

TEST(IndexAccuracy, RepeatsOfASubjectAreNeverBothTrainedOnAndHeldOut) {
  // Features hold nothing about shape but name the subject. Split by sample, ridge would seem good; by subject it
  // cannot beat the mean.
  std::vector<Sample> samples;
  const World world;
  for (std::uint64_t s = 0; s < 150; ++s)
    for (std::uint64_t c = 0; c < 4; ++c) {
      Sample sample = world.sample(s, c);
      Rng name = Rng::for_item(3, 3, s);
      Rng noise = Rng::for_item(4, s, c);
      for (auto& x : sample.feature) x = static_cast<float>(name.normal() + 0.1 * noise.normal());
      samples.push_back(sample);
    }
  auto bytes = build_index({}, source_of(samples));
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto index = Index::parse(std::move(*bytes), "names");
  ASSERT_TRUE(index);
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    EXPECT_GT(index->info().answer_mae[m], 0.9F * index->info().prior_mae[m]) << kMeasurementTable[m].id;
}

TEST(IndexAccuracy, MissingFeaturesCostLittle) {
  const World world;
  const Index& index = straight_index();
  auto scratch = index.make_scratch();
  double whole = 0, holes = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    Sample q = world.sample(kFreshSubjects + i, 0);
    whole += mean_error(values_of(*index.query(q.feature, {}, *scratch)), q.truth);
    q.feature[static_cast<std::size_t>(i) % q.feature.size()] = std::numeric_limits<float>::quiet_NaN();
    holes += mean_error(values_of(*index.query(q.feature, {}, *scratch)), q.truth);
  }
  EXPECT_LT(holes, 1.5 * whole);
}

TEST(IndexAccuracy, GroupsOfNoiseAreWeighedDown) {
  const World world;
  BuildOptions options;
  options.groups = {{"signal", 120}, {"junk", 60}};
  std::vector<Sample> samples;
  for (std::uint64_t s = 0; s < 600; ++s) {
    Sample sample = world.sample(s, 0);
    Rng rng = Rng::for_item(5, 5, s);
    for (int i = 0; i < 60; ++i) sample.feature.push_back(static_cast<float>(rng.normal()));
    samples.push_back(sample);
  }
  auto bytes = build_index(options, source_of(samples));
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto index = Index::parse(std::move(*bytes), "junk");
  ASSERT_TRUE(index);
  const auto& groups = index->info().groups;
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].name, "signal");
  EXPECT_LT(groups[1].weight, 0.5F * groups[0].weight);
  EXPECT_GT(groups[0].error_without, 2 * index->info().error_with_all);
}

}  // namespace
}  // namespace im2fit::index
