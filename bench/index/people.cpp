// SPDX-License-Identifier: Apache-2.0
#include "bench/index/people.h"

#include <algorithm>
#include <cmath>

#include "core/rng.h"
#include "train/dataset/dataset_shard.h"
#include "train/dataset/features.h"

namespace im2fit::bench {
namespace {

void deal(People& people, index::Sample sample) {
  auto& to = sample.subject % kHeldOutEvery == 0 ? people.queries : people.models;
  to.push_back(std::move(sample));
}

}  // namespace

Result<People> read_people(const std::string& folder, std::size_t most) {
  const std::string folders[] = {folder};
  const auto shards = lab::ShardSet::find(folders);
  if (!shards) return shards.error();
  People people;
  people.groups = lab::feature_groups();
  std::size_t feature_size = 0;
  for (const auto& group : people.groups) feature_size += group.count;
  std::size_t odd_size = 0;
  const Status read = shards->read([&](const index::Sample& sample) {
    if (sample.feature.size() != feature_size) {
      odd_size = sample.feature.size();
      return false;
    }
    if (sample.is_entry()) deal(people, sample);
    return people.models.size() + people.queries.size() < most;
  });
  if (!read) return read.error();
  if (odd_size > 0)
    return Error{ErrorCode::invalid_argument, folder + ": features of " + std::to_string(odd_size) +
                                                  " values, expected " + std::to_string(feature_size) +
                                                  "; make the dataset again"};
  people.origin = "im2fit-lab dataset";
  return people;
}

People invent_people(std::size_t count, std::uint64_t seed) {
  constexpr std::size_t kLatents = 10, kFeatures = 501;
  constexpr double kNoise = 0.8;
  Rng rng(seed);
  std::vector<double> loading(kFeatures * kLatents), bend(kFeatures * kLatents), girth(kMeasurementCount * kLatents);
  // The first latent is posture: a third of the signal, and nothing of the body.
  for (std::size_t i = 0; i < loading.size(); ++i) loading[i] = rng.normal(0, i % kLatents == 0 ? 0.6 : 0.27);
  for (double& b : bend) b = rng.normal(0, 0.03);
  for (std::size_t i = 0; i < girth.size(); ++i) girth[i] = i % kLatents == 0 ? 0 : rng.normal(0, 25);
  People people;
  people.groups = index::default_groups(kFeatures);
  people.origin = "invented people";
  for (std::size_t n = 0; n < count; ++n) {
    index::Sample s;
    s.subject = n;
    s.woman = n % 2 == 1;
    std::vector<double> latent(kLatents);
    for (double& l : latent) l = rng.normal();
    latent[1] += s.woman ? -0.8 : 0.8;
    for (std::size_t f = 0; f < kFeatures; ++f) {
      double value = rng.normal(0, kNoise);
      for (std::size_t l = 0; l < kLatents; ++l)
        value += loading[f * kLatents + l] * latent[l] + bend[f * kLatents + l] * latent[l] * latent[l];
      s.feature.push_back(static_cast<float>(value));
    }
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      double value = 1000;
      for (std::size_t l = 0; l < kLatents; ++l) value += girth[m * kLatents + l] * latent[l];
      s.truth[m] = static_cast<float>(value);
    }
    for (const double l : latent) s.body.push_back(static_cast<float>(l));
    deal(people, std::move(s));
  }
  return people;
}

}  // namespace im2fit::bench
