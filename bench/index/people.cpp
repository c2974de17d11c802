// SPDX-License-Identifier: Apache-2.0
#include "bench/index/people.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>

#include "base/container.h"
#include "base/file.h"
#include "base/rng.h"
#include "synth/dataset_shard.h"
#include "synth/features.h"

namespace im2fit::bench {
namespace {

void deal(People& people, index::Sample sample) {
  auto& to = sample.subject % kHeldOutEvery == 0 ? people.queries : people.models;
  to.push_back(std::move(sample));
}

// The key a shard was made with: whoever asks for a folder wants what lies in it.
Result<std::uint64_t> key_of(const std::string& path) {
  auto file = MappedFile::open(path);
  if (!file) return file.error();
  const auto container = ContainerReader::parse(file->bytes(), "I2DS", 1, path, false);
  if (!container) return container.error();
  const auto meta = container->section("meta");
  if (!meta) return meta.error();
  std::uint64_t key = 0;
  if (meta->size() < sizeof key) return Error{ErrorCode::corrupt, path + ": its meta section is too short"};
  std::memcpy(&key, meta->data(), sizeof key);
  return key;
}

Result<std::map<std::uint64_t, synth::Chunk>> read_chunks(const std::string& folder) {
  std::map<std::uint64_t, synth::Chunk> by_subject;
  std::error_code failed;
  for (const auto& file : std::filesystem::directory_iterator(folder, failed)) {
    if (file.path().extension() != ".i2d") continue;
    const std::string path = file.path().string();
    const auto key = key_of(path);
    if (!key) return key.error();
    auto chunk = synth::read_shard(path, *key);
    if (!chunk) return chunk.error();
    if (chunk->samples.empty()) continue;
    const std::uint64_t first = chunk->samples.front().subject;
    if (!by_subject.emplace(first, std::move(*chunk)).second)
      return Error{ErrorCode::invalid_argument, folder + ": shards of more than one run; name a folder of one run"};
  }
  if (failed || by_subject.empty())
    return Error{ErrorCode::not_found,
                 folder + ": no shards (*.i2d) there; make some: im2fit-lab dataset --out " + folder};
  return by_subject;
}

}  // namespace

Result<People> read_people(const std::string& folder, std::size_t most) {
  auto chunks = read_chunks(folder);
  if (!chunks) return chunks.error();
  People people;
  people.groups = synth::feature_groups();
  std::size_t feature_size = 0;
  for (const auto& group : people.groups) feature_size += group.count;
  for (auto& [first, chunk] : *chunks) {
    for (index::Sample& sample : chunk.samples) {
      if (sample.feature.size() != feature_size)
        return Error{ErrorCode::invalid_argument, folder + ": features of " + std::to_string(sample.feature.size()) +
                                                      " values, expected " + std::to_string(feature_size) +
                                                      "; make the dataset again"};
      if (!sample.calibrate_only && people.models.size() + people.queries.size() < most)
        deal(people, std::move(sample));
    }
    chunk.samples.clear();
  }
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
