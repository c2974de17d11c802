// SPDX-License-Identifier: Apache-2.0
// What the hand-written tiers share around their loop over the pairs of one source.
//
// They take the candidates as they lie, in row order and without gathering: a candidate out of range costs a lane but
// no branch. A pair is counted by adding 32 bytes to the 32 byte counters of each of its two points: one table entry
// for (f1, f2) plus one for f3. Byte b of the 32 is bin b of the 33; the last bin of f3 is what the others leave of
// the number of pairs. Byte counters overflow after 255 pairs, hence they are emptied into the 32-bit counts after as
// many sources, each of which adds at most one to any other point, and a source's own after as many lanes.
//
// No inline functions and no templates here: files compiled for one instruction set include this.
#pragma once

#include <cstdint>
#include <span>

#include "kernels/fpfh/fpfh.h"

namespace im2fit::fpfh_detail {

inline constexpr int kCountBytes = 32;
inline constexpr int kLanesUntilOverflow = 255;

// Byte offsets into Increments: f1 * 512 + f2 * 32 into `first`, f3 * 32 into `third`. Lanes that do not count take
// kNoPair, whose entries are zero.
struct Increments {
  alignas(64) std::uint8_t first[kFpfhBins * 16 * kCountBytes];
  alignas(64) std::uint8_t third[kFpfhBins * kCountBytes];
};
extern const Increments kIncrements;
// A pair's code: the offset into `first` in the low half, that into `third` in the high half.
inline constexpr std::int32_t kNoPair = (11 * kCountBytes) | ((10 * kCountBytes) << 16);

// One source and its candidates.
struct PairTask {
  const float *x, *y, *z, *nx, *ny, *nz;  // metres; readable kSlack values past the last point
  const std::uint8_t* needed;             // likewise
  std::uint8_t* count_bytes;              // kCountBytes a point; likewise, and writable
  std::int32_t* own_counts;               // the source's 32-bit counts
  int source;
  bool source_needed;  // otherwise only pairs with a needed point have to be counted
  float radius_squared;
  const std::int32_t* ranges;  // begin, end of candidates > source
  int range_count;
  // Filled by the tier: neighbours whose pair must be decided carefully, and neighbours without a normal.
  std::int32_t* careful_list;
  int careful_count;
  std::int32_t* blank_list;
  int blank_count;
};
inline constexpr int kSlack = 16;

using CountPairsFunction = void(PairTask& task);

void fpfh_in_blocks(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                    FpfhWorkspace& work, std::span<float> out, CountPairsFunction* count_pairs);

}  // namespace im2fit::fpfh_detail
