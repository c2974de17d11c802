// SPDX-License-Identifier: Apache-2.0
// What the hand-written tiers share around their loop over the pairs of one source.
//
// They take the candidates as they lie, in row order and without collecting: a candidate out of range costs a lane
// but no branch. A pair is counted by adding 32 bytes, read from a table by its three bins, to the 32 byte counters
// of each of its two points. Byte b of the 32 is bin b of the 33; the last bin of f3 is what the others leave of the
// number of pairs. Byte counters overflow after 255 pairs, hence they are emptied into the 32-bit counts after as
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

// What a pair adds to both its points, at (f1 * 121 + f2 * 11 + f3) * kCountBytes: its code. Lanes that do not count
// take kNoPair, whose entry is zero.
inline constexpr int kNoPair = kFpfhBins * kFpfhBins * kFpfhBins * kCountBytes;
struct Increments {
  alignas(64) std::uint8_t bytes[kNoPair + kCountBytes];
};
extern const Increments kIncrements;

// The numbers of fpfh_constants.h as vector code wants them, defined where no compiler sees their values: it would
// rather build each anew, every time.
struct VectorConstants {
  alignas(32) float cosine[5][8];  // of f1's edges, whole vectors
  alignas(32) float sine[5][8];
  alignas(16) float lanes[12];  // cosine 0..4, sine 0..4, kNearTie, kNearlyParallel
};
extern const VectorConstants kVectorConstants;

// One source and its candidates.
struct PairTask {
  const float *x, *y, *z, *nx, *ny, *nz;  // metres; readable kSlack values past the last point, where x is NaN
  const std::uint8_t* needed;             // likewise
  std::uint8_t* count_bytes;              // kCountBytes a point; likewise, and writable
  std::int32_t* counts;                   // kFpfhSize a point, for what is counted one by one
  int source;
  bool source_needed;  // otherwise only pairs with a needed point have to be counted
  float radius_squared;
  // Begin and end of candidates > source. A block may run over an end: what it meets there is out of reach.
  const std::int32_t* ranges;
  int range_count;
  // Filled by the tier: neighbours it left aside, because the careful path must decide or the points coincide.
  std::int32_t* aside_list;
  int aside_count;
};
inline constexpr int kSlack = 16;

// Two ways to count the pairs of a source: it has a normal, or it has none. A pair with one normal counts in bin 0
// but for f3 at the point that has it, which is known; a pair with none counts in bin 0.
struct PairCounters {
  void (*with_normal)(PairTask& task);
  void (*blank)(PairTask& task);
};

void fpfh_in_blocks(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                    FpfhWorkspace& work, std::span<float> out, const PairCounters& counters);

}  // namespace im2fit::fpfh_detail
