// SPDX-License-Identifier: Apache-2.0
// The samples of consecutive subjects as a file (core/container.h, magic "I2DS"; docs/dataset.md), and any number of
// such files read as one.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/guidance.h"
#include "core/status.h"
#include "train/index/sample.h"

namespace im2fit::lab {

// All that a sample depends on besides its subject's number. Shards of one run share it.
struct RunKey {
  std::uint64_t dataset_version = 0;  // kDatasetVersion: how a subject becomes samples
  std::uint64_t input_key = 0;        // of the body and tracker files
  std::uint64_t seed = 0;
  std::uint32_t family = 0;
  std::uint32_t captures_per_subject = 0;
  std::uint32_t frames_min = 0;
  std::uint32_t frames_max = 0;
  double wide_share = 0;
  double landscape_share = 0;
  double anywhere_share = 0;
  double other_sensor_share = 0;
  std::uint32_t plain = 0;
  std::uint32_t ood_every = 0;
  std::uint32_t feature_size = 0;
  std::uint32_t body_size = 0;
  std::uint32_t turn_every = 0;
  FitLayout fit;                 // of a fitted shape; of size 0: no sample has one
  std::uint32_t shape_key = 0;   // of the shape space behind the fits
  std::uint32_t turn_below = 0;  // subjects numbered below
  std::uint32_t clothed_every = 0;
  std::uint32_t ood_below = 0;
  std::uint32_t again_below = 0;
  std::uint32_t reserved = 0;

  bool operator==(const RunKey&) const = default;
  std::uint64_t hash() const;
  std::string text() const;  // a line a field, "seed 1"
  // "seed 1, not 2": the first field in which `other` differs.
  std::string difference(const RunKey& other) const;
};

struct SubjectRange {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
  std::uint64_t end() const { return first + count; }
  bool operator==(const SubjectRange&) const = default;
};

// What came of the subjects of a shard.
struct ChunkCounts {
  std::int32_t subjects = 0;  // with at least one sample
  std::int32_t samples = 0;
  std::int32_t captures_failed = 0;
  std::int32_t captures_missing = 0;
  std::int64_t frames_seen = 0;
  std::array<std::int64_t, kGuidanceCount> refused{};
};

// Features are kept in half precision, divided by 2^feature_exponent(): fit_to_shard() rounds a sample to the values
// read back.
struct Chunk {
  std::vector<index::Sample> samples;  // in the order of subjects, features and bodies of the run's sizes
  ChunkCounts counts;                  // counts.samples is samples.size()
};
void fit_to_shard(index::Sample& sample);
// Of perception/observe's features: 10 for the silhouette's area, which half precision would make infinite; else 0.
int feature_exponent(std::size_t feature);

// "samples-<run>-<first subject>-<count>.i2d"
std::string shard_name(const RunKey& run, const SubjectRange& range);
Status write_shard(const std::string& path, const RunKey& run, const SubjectRange& range, const Chunk& chunk);
// Another run or range than expected is an error, like damage.
Result<Chunk> read_shard(const std::string& path, const RunKey& run, const SubjectRange& range);

struct ShardAbout {
  std::string path;
  RunKey run;
  SubjectRange range;
  ChunkCounts counts;
};
// The head of a shard; its samples are not read, nor their checksums checked.
Result<ShardAbout> about_shard(const std::string& path);

// Any number of shards of one run, wherever they lie, as one row of samples. Holds one shard at a time.
class ShardSet {
 public:
  // All *.i2d files in `folders`. Errors: none; of different runs; the same subjects twice; subjects missing between
  // the first and the last; damaged heads. The message names files and subjects.
  static Result<ShardSet> find(std::span<const std::string> folders);

  const RunKey& run() const { return shards_.front().run; }
  const std::vector<ShardAbout>& shards() const { return shards_; }  // in the order of subjects
  SubjectRange range() const;
  // An error that names missing or extra subjects, unless these are exactly the subjects of the shard.
  Status expect(const SubjectRange& wanted) const;
  // In the order of subjects. Errors: a damaged shard; `take` has then got the samples before the damage. `take` may
  // return false to end the reading.
  Status read(const std::function<bool(const index::Sample&)>& take) const;

 private:
  std::vector<ShardAbout> shards_;
};

// IEEE 754 binary16, by integers alone: the same bits on every machine.

// Nearest, ties to even; beyond 65504 infinity; NaN stays NaN.
constexpr std::uint16_t half_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000U;
  const std::uint32_t size = bits & 0x7FFFFFFFU;
  if (size > 0x7F800000U) return static_cast<std::uint16_t>(sign | 0x7E00U);
  if (size >= 0x47800000U) return static_cast<std::uint16_t>(sign | 0x7C00U);  // 65536 and more
  const int exponent = static_cast<int>(size >> 23) - 127;
  if (exponent < -25) return static_cast<std::uint16_t>(sign);
  // Below 2^-14 the step no longer shrinks: more bits fall away, the leading one is written out.
  const bool small = exponent < -14;
  const std::uint32_t significand = small ? (size & 0x7FFFFFU) | 0x800000U : size - (112U << 23);
  const int dropped = small ? 13 + (-14 - exponent) : 13;
  const std::uint32_t rest = significand & ((1U << dropped) - 1);
  const std::uint32_t halfway = 1U << (dropped - 1);
  std::uint32_t kept = significand >> dropped;
  if (rest > halfway || (rest == halfway && (kept & 1U) != 0)) ++kept;  // may carry into the exponent, rightly
  return static_cast<std::uint16_t>(sign | kept);
}

constexpr float float_of(std::uint16_t half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16;
  const std::uint32_t exponent = half >> 10 & 0x1FU;
  const std::uint32_t significand = half & 0x3FFU;
  if (exponent == 0) {  // zero and what lies below 2^-14: exact in float
    const float size = static_cast<float>(significand) * 0x1p-24F;
    return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(size));
  }
  const std::uint32_t wide = exponent == 31 ? 0x7F800000U : (exponent + 112) << 23;
  return std::bit_cast<float>(sign | wide | significand << 13);
}

}  // namespace im2fit::lab
