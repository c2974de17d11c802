// SPDX-License-Identifier: Apache-2.0
// The samples of one chunk of subjects as a file (base/container.h, magic "I2DS").
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/status.h"
#include "index/sample.h"
#include "kernels/core/guidance.h"

namespace im2fit::synth {

struct Chunk {
  std::vector<index::Sample> samples;  // of one feature and one body size
  std::int32_t subjects = 0;           // with at least one sample
  std::int32_t captures_failed = 0;
  std::int32_t captures_missing = 0;
  std::int64_t frames_seen = 0;
  std::array<std::int64_t, kGuidanceCount> refused{};
};

// `key` says what the chunk was made from; reading with another key is an error.
Status write_shard(const std::string& path, std::uint64_t key, const Chunk& chunk);
Result<Chunk> read_shard(const std::string& path, std::uint64_t key);

}  // namespace im2fit::synth
