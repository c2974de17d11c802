// SPDX-License-Identifier: Apache-2.0
// The loop of raw_row.h, for the files that compile it once for each instruction set.
#pragma once

#include <algorithm>

#include "train/render/raw_row.h"

namespace im2fit::lab {
namespace {

constexpr int kBlock = 64;

// Rng(state).next()
inline __attribute__((always_inline)) std::uint64_t mixed(std::uint64_t state) {
  std::uint64_t z = state + kRowStep;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

// In passes over short blocks: the vectoriser can handle each of them.
inline __attribute__((always_inline)) void raw_row_loop(const RawRow& row, int count, std::int32_t* out) {
  std::uint64_t bits[kBlock];
  std::int32_t sum[kBlock], chance[kBlock];
  for (int first = 0; first < count; first += kBlock) {
    const int n = std::min(kBlock, count - first);
    const std::uint64_t seed = row.seed + kRowStep * static_cast<std::uint64_t>(first);
    for (int i = 0; i < n; ++i) bits[i] = mixed(seed + kRowStep * static_cast<std::uint64_t>(i));
    for (int i = 0; i < n; ++i) {
      // The four 16-bit parts, two at a time.
      const std::uint64_t two = (bits[i] & 0x0000FFFF0000FFFFULL) + ((bits[i] >> 16) & 0x0000FFFF0000FFFFULL);
      sum[i] = static_cast<std::int32_t>((two + (two >> 32)) & 0xFFFFFFFFULL);
      chance[i] = static_cast<std::int32_t>((bits[i] * kChanceFactor) >> 48);
    }
    const float* exact = row.exact + first;
    const float* sigma = row.sigma + first;
    const float* patch = row.patch + first;
    const std::int32_t* lost = row.lost + first;
    std::int32_t* step = out + first;
    for (int i = 0; i < n; ++i) {
      const float white = (static_cast<float>(sum[i]) - 131070.0F) * (1.7320508F / 65536.0F);
      const float raw = exact[i] + sigma[i] * (row.white_share * white + row.patch_share * patch[i]);
      const float up = raw + 0.5F;
      const float last = static_cast<float>(kRawCount - 1);
      const float kept = up < last ? up : last;
      // Nearer than the sensor can express (raw < -0.5) is as lost as farther.
      const bool delivered = (chance[i] >= lost[i]) & (raw >= -0.5F);
      step[i] = delivered ? static_cast<std::int32_t>(kept) : kRawCount;
    }
  }
}

}  // namespace
}  // namespace im2fit::lab
