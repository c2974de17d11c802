// SPDX-License-Identifier: Apache-2.0
// Intervals of people near by and far away, where it is known how errors grow with the distance.
#include "index/noise_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/rng.h"
#include "tests/index/synthetic_people.h"
#include "train/index/calibration.h"

namespace im2fit::index {
namespace {

using testing::kFreshSubjects;
using testing::World;

constexpr std::array kBandEdgesMm = {1900, 2500, 3000, 3500, 4000};
constexpr std::size_t kBands = kBandEdgesMm.size() - 1;

// Errors of one standard deviation up to 2.5 m, of 1.9 at 4 m, less with more frames.
std::vector<HeldOut> people(std::uint64_t seed, int count) {
  std::vector<HeldOut> rows;
  for (int i = 0; i < count; ++i) {
    Rng rng = Rng::for_item(seed, 0xD157, static_cast<std::uint64_t>(i));
    HeldOut& row = rows.emplace_back();
    row.subject = static_cast<std::uint32_t>(i);
    row.frame_count = 3 + 2 * rng.index(4);
    row.distance_mm = static_cast<int>(rng.uniform(kBandEdgesMm.front(), kBandEdgesMm.back()));
    const double metres = std::max(0.0, row.distance_mm * 1e-3 - 2.5);
    const double sd = std::sqrt(0.8 + 1.3 / (row.frame_count + 1) + 1.16 * metres * metres);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      row.truth[m] = rng.normal(0, sd * (1 + 0.1 * static_cast<double>(m)));
      row.spread[m] = 1;
    }
  }
  return rows;
}

// Share of truths inside, by bands of distance, as the model states it with the distance known or not.
std::array<double, kBands> coverage(const IntervalModel& model, const std::vector<HeldOut>& rows, bool informed) {
  std::array<double, kBands> inside{}, all{};
  for (const HeldOut& row : rows) {
    std::size_t band = 0;
    while (row.distance_mm >= kBandEdgesMm[band + 1]) ++band;
    const double noise = model.noise.width(row.frame_count, informed ? row.distance_mm : 0);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      const auto floor = static_cast<double>(model.spread_floor[m]);
      const double width = noise * (model.kind == IntervalKind::constant ? floor : 0.5 * (floor + row.spread[m]));
      const double error = row.truth[m] - row.answer[m];
      all[band] += 1;
      inside[band] += error >= width * static_cast<double>(model.quantiles[2 * m]) &&
                              error <= width * static_cast<double>(model.quantiles[2 * m + 1])
                          ? 1
                          : 0;
    }
  }
  for (std::size_t b = 0; b < kBands; ++b) inside[b] /= all[b];
  return inside;
}

TEST(NoiseModel, IntervalsHoldAtEveryDistance) {
  const auto learned = people(1, 6000), fresh = people(2, 6000);
  for (const double share : coverage(calibrate_intervals(learned), fresh, true)) EXPECT_NEAR(share, 0.95, 0.012);
}

TEST(NoiseModel, WithoutTheDistanceTheyDoNot) {
  auto learned = people(1, 6000);
  const auto fresh = people(2, 6000);
  for (HeldOut& row : learned) row.distance_mm = 0;
  const IntervalModel model = calibrate_intervals(learned);
  EXPECT_NEAR(model.noise.width(5, 2000), model.noise.width(5, 4000), 1e-3);
  const auto share = coverage(model, fresh, false);
  EXPECT_GT(share.front(), 0.97);
  EXPECT_LT(share.back(), 0.91);
}

TEST(NoiseModel, FindsTheLawItWasDrawnBy) {
  const NoiseModel noise = calibrate_intervals(people(3, 20000)).noise;
  const auto variance = [](double frames, double metres) {
    return 0.8 + 1.3 / (frames + 1) + 1.16 * metres * metres;
  };
  const double at_best = noise.width(9, 2000);
  EXPECT_NEAR(noise.width(9, 4000) / at_best, std::sqrt(variance(9, 1.5) / variance(9, 0)), 0.1);
  for (const int frames : {1, 3, 30})  // 1 and 30: as no person was seen
    EXPECT_NEAR(noise.width(frames, 2000) / at_best, std::sqrt(variance(frames, 0) / variance(9, 0)), 0.06) << frames;
  EXPECT_EQ(noise.width(3, 0), noise.width(3, 4000)) << "a distance that is not known is taken for the farthest";
}

// People whose errors grow with how new they look, and not with how they stand.
std::vector<HeldOut> people_of_novelty(std::uint64_t seed, double least, double most, bool known) {
  std::vector<HeldOut> rows(4000);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Rng rng = Rng::for_item(seed, 0x4E0, i);
    rows[i].subject = static_cast<std::uint32_t>(i);
    rows[i].frame_count = 9;
    rows[i].distance_mm = 2000;
    const double novelty = rng.uniform(least, most);
    rows[i].novelty = known ? novelty : 0;
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      rows[i].truth[m] = rng.normal(0, std::sqrt(0.3 + 0.7 * novelty));
      rows[i].spread[m] = 1;
    }
  }
  return rows;
}

// Of three in four of the people learned from novelty is below 1.5; of those measured it is 2 to 3.
TEST(NoiseModel, IntervalsHoldForPeopleWhoLookNew) {
  for (const bool known : {true, false}) {
    std::vector<HeldOut> rows = people_of_novelty(5, 0.5, 1.5, known);
    const auto newer = people_of_novelty(6, 1.5, 2.5, known);
    rows.insert(rows.end(), newer.begin(), newer.begin() + 1333);
    const IntervalModel model = calibrate_intervals(rows);
    EXPECT_EQ(model.noise.share[4] > 0, known);
    double inside = 0;
    const auto fresh = people_of_novelty(7, 2, 3, known);
    for (const HeldOut& row : fresh)
      for (std::size_t m = 0; m < kMeasurementCount; ++m) {
        const double width = model.noise.width(9, 2000, row.novelty) * static_cast<double>(model.spread_floor[m]);
        inside += row.truth[m] >= width * static_cast<double>(model.quantiles[2 * m]) &&
                          row.truth[m] <= width * static_cast<double>(model.quantiles[2 * m + 1])
                      ? 1.0 / static_cast<double>(fresh.size() * kMeasurementCount)
                      : 0;
      }
    if (known) {
      EXPECT_NEAR(inside, 0.95, 0.012);
    } else {
      EXPECT_LT(inside, 0.9);
    }
  }
}

// What is seen from far away is noisier.
Sample seen_from(const World& world, std::uint64_t subject, int distance_mm) {
  Sample s = world.sample(subject, static_cast<std::uint64_t>(distance_mm));
  s.distance_mm = distance_mm;
  Rng rng = Rng::for_item(10, subject, static_cast<std::uint64_t>(distance_mm));
  const double sd = 40 * std::max(0.0, distance_mm * 1e-3 - 2.5);
  for (float& v : s.feature) v += static_cast<float>(rng.normal(0, sd));
  return s;
}

TEST(NoiseModel, AFarPersonsIntervalIsWiderAndHoldsAsWell) {
  const World world;
  std::vector<Sample> samples;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    Rng rng = Rng::for_item(11, 0, i);
    samples.push_back(seen_from(world, i, static_cast<int>(rng.uniform(1900, 4000))));
  }
  auto bytes = build_index(testing::options_for(world), source_of(samples));
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto index = Index::parse(std::move(*bytes), "distances");
  ASSERT_TRUE(index);
  const auto scratch = index->make_scratch();
  const int count = 600;
  for (const int distance_mm : {2100, 3800}) {
    int inside = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      const Sample q = seen_from(world, kFreshSubjects + i, distance_mm);
      const Answer a = *index->query(q.feature, {.distance_mm = distance_mm}, *scratch);
      for (std::size_t m = 0; m < kMeasurementCount; ++m)
        inside += q.truth[m] >= a.measurements[m].low && q.truth[m] <= a.measurements[m].high ? 1 : 0;
    }
    EXPECT_NEAR(inside / (count * static_cast<double>(kMeasurementCount)), 0.95, 0.025) << distance_mm;
  }
  const Sample q = seen_from(world, kFreshSubjects, 2100);
  const Answer near = *index->query(q.feature, {.distance_mm = 2100}, *scratch);
  const Answer far = *index->query(q.feature, {.distance_mm = 3800}, *scratch);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    EXPECT_EQ(near.measurements[m].value, far.measurements[m].value);
    EXPECT_GT(far.measurements[m].high - far.measurements[m].low,
              1.1F * (near.measurements[m].high - near.measurements[m].low));
  }
}

}  // namespace
}  // namespace im2fit::index
