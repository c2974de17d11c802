// SPDX-License-Identifier: Apache-2.0
#include "synth/dataset_shard.h"

#include <algorithm>

#include "base/container.h"
#include "base/file.h"

namespace im2fit::synth {
namespace {

constexpr char kMagic[] = "I2DS";
constexpr std::uint32_t kVersion = 1;

struct ShardMeta {
  std::uint64_t key = 0;
  std::uint32_t sample_count = 0;
  std::uint32_t feature_size = 0;
  std::uint32_t body_size = 0;
  std::int32_t subjects = 0;
  std::int32_t captures_failed = 0;
  std::int32_t captures_missing = 0;
  std::int64_t frames_seen = 0;
  std::array<std::int64_t, kGuidanceCount> refused{};
};

struct RowMeta {
  std::uint64_t subject = 0;
  std::int32_t frame_count = 0;
  std::uint32_t flags = 0;  // 1 woman, 2 calibrate_only
};

}  // namespace

Status write_shard(const std::string& path, std::uint64_t key, const Chunk& chunk) {
  ShardMeta meta{key,
                 static_cast<std::uint32_t>(chunk.samples.size()),
                 0,
                 0,
                 chunk.subjects,
                 chunk.captures_failed,
                 chunk.captures_missing,
                 chunk.frames_seen,
                 chunk.refused};
  std::vector<RowMeta> rows;
  std::vector<float> features, bodies, truths;
  for (const index::Sample& s : chunk.samples) {
    meta.feature_size = static_cast<std::uint32_t>(s.feature.size());
    meta.body_size = static_cast<std::uint32_t>(s.body.size());
    rows.push_back({s.subject, s.frame_count, (s.woman ? 1U : 0U) | (s.calibrate_only ? 2U : 0U)});
    features.insert(features.end(), s.feature.begin(), s.feature.end());
    bodies.insert(bodies.end(), s.body.begin(), s.body.end());
    truths.insert(truths.end(), s.truth.begin(), s.truth.end());
  }
  ContainerWriter out(kMagic, kVersion);
  out.add_array("meta", std::span<const ShardMeta>(&meta, 1));
  out.add_array("rows", std::span<const RowMeta>(rows));
  out.add_array("features", std::span<const float>(features));
  out.add_array("bodies", std::span<const float>(bodies));
  out.add_array("truths", std::span<const float>(truths));
  return write_file_atomically(path, out.finish());
}

Result<Chunk> read_shard(const std::string& path, std::uint64_t key) {
  auto file = MappedFile::open(path);
  if (!file) return file.error();
  auto container = ContainerReader::parse(file->bytes(), kMagic, kVersion, path);
  if (!container) return container.error();
  const auto meta_row = container->array<ShardMeta>("meta", 1);
  if (!meta_row) return meta_row.error();
  const ShardMeta& meta = (*meta_row)[0];
  if (meta.key != key)
    return Error{ErrorCode::invalid_argument, path + ": made with other options or other body and tracker files"};
  const std::size_t n = meta.sample_count;
  const auto rows = container->array<RowMeta>("rows", n);
  if (!rows) return rows.error();
  const auto features = container->array<float>("features", n * meta.feature_size);
  if (!features) return features.error();
  const auto bodies = container->array<float>("bodies", n * meta.body_size);
  if (!bodies) return bodies.error();
  const auto truths = container->array<float>("truths", n * kMeasurementCount);
  if (!truths) return truths.error();
  Chunk chunk;
  chunk.subjects = meta.subjects;
  chunk.captures_failed = meta.captures_failed;
  chunk.captures_missing = meta.captures_missing;
  chunk.frames_seen = meta.frames_seen;
  chunk.refused = meta.refused;
  for (std::size_t i = 0; i < n; ++i) {
    index::Sample s;
    s.subject = (*rows)[i].subject;
    s.frame_count = (*rows)[i].frame_count;
    s.woman = ((*rows)[i].flags & 1U) != 0;
    s.calibrate_only = ((*rows)[i].flags & 2U) != 0;
    const auto feature = features->subspan(i * meta.feature_size, meta.feature_size);
    s.feature.assign(feature.begin(), feature.end());
    const auto body = bodies->subspan(i * meta.body_size, meta.body_size);
    s.body.assign(body.begin(), body.end());
    std::copy_n(truths->begin() + static_cast<std::ptrdiff_t>(i * kMeasurementCount), kMeasurementCount,
                s.truth.begin());
    chunk.samples.push_back(std::move(s));
  }
  return chunk;
}

}  // namespace im2fit::synth
