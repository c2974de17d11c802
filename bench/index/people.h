// SPDX-License-Identifier: Apache-2.0
// The people in the index and the people who query it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"
#include "train/index/sample.h"

namespace im2fit::bench {

inline constexpr std::uint64_t kHeldOutEvery = 20;  // of the subjects one is in no index and only queried

struct People {
  std::vector<index::Sample> models, queries;
  std::vector<index::FeatureGroup> groups;
  std::string origin;  // for the report
};

// Shards of one run of `im2fit-lab dataset`; at most `most` samples. Leaves out those that only calibrate intervals:
// the indexes compared here have no intervals.
Result<People> read_people(const std::string& folder, std::size_t most);

// No data at hand: bodies from ten numbers, 501 features that bend with them and are noisy as the real ones are
// (nearly half of their variance). For checking that the bench works; their errors mean nothing.
People invent_people(std::size_t count, std::uint64_t seed);

}  // namespace im2fit::bench
