// SPDX-License-Identifier: Apache-2.0
// How round trunks and legs are: what distinguishes people from coats, chairs and shelves.
#include <algorithm>
#include <cmath>

#include "perception/segment/blobs.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [legs]  of 57 people without a clear head 47 have such legs, of 240 pieces of furniture of a person's size
//           2 (commit 1e3516a)
//   [round] came with the same commit: of 1,000 empty frames 436 showed a user before, 3 after; all changes
//           together
//   [coats] coats on stands are no people (commit 78a99e4): chosen on synthetic rooms, no measurement on record
namespace im2fit::segment::trunk_limits {

// Trunks: the bulge of their rows.
constexpr float kHalfMm = 180.0F;   // of a row, either side of the middle, most; [coats]
constexpr float kDepthMm = 280.0F;  // from the depth given: still the same surface; [round]
constexpr int kWidthMinCells = 6;   // of a row, least; [round]
constexpr int kRowsMin = 8;         // of a trunk or of legs, least: a disparity step of 20 mm then leaves 3; [round]
constexpr float kUnknownMisfit = 2.0F;        // of fewer rows; [round]
constexpr float kFlatShare = 2.0F;            // edge over bulge, of a bulge below 1 mm; [round]
constexpr float kBulgeMinMm = 18.0F;          // people have 18 to 80; [round]
constexpr float kBulgeMinSpreadMm = 8.0F;     // a misfit of 1 below that; [round]
constexpr float kBulgeMaxMm = 80.0F;          // and most; [round]
constexpr float kBulgeMaxSpreadMm = 30.0F;    // a misfit of 1 above that; [round]
constexpr float kEdgeShareMin = 0.58F;        // of the bulge, beyond half way: below, sides are straight; [round]
constexpr float kEdgeShareMinSpread = 0.2F;   // a misfit of 1 below that; [round]
constexpr float kEdgeShareMax = 0.93F;        // above, there is a step; [round]
constexpr float kEdgeShareMaxSpread = 0.08F;  // a misfit of 1 above that; [round]

// Legs: rows of the lower part.
constexpr float kLegWideMinMm = 80.0F;   // widest run of a row, mean, least; [legs]
constexpr float kLegWideMaxMm = 240.0F;  // and most, with trousers; [legs]
constexpr float kLegBulgeMinMm = 17.0F;  // middle before the edges, mean, least; [legs]
constexpr float kLegBulgeMaxMm = 75.0F;  // and most; [legs]
constexpr int kLegCellsMin = 4;          // of a row across a leg, to see it round; [legs]
constexpr float kLegRunsMin = 1.4F;      // runs of a row, mean, least: one leg or two; [legs]
constexpr float kLegRunsMax = 2.35F;     // and most; [legs]

}  // namespace im2fit::segment::trunk_limits

namespace im2fit::segment {

using namespace trunk_limits;

namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

// Rows r_first..r_last about column c: how far the edges lie behind the middle on average, and the points half way
// behind the middle. Averages over sixths of a row and all rows: a disparity step of 20 mm leaves 3.
BlobFinder::TrunkShape BlobFinder::trunk_shape(const Grid& grid, int blob, int c, int r_first, int r_last,
                                               float z_mm) const {
  const auto label = static_cast<std::uint16_t>(blob + 1);
  const float cell_mm = static_cast<float>(grid.step) * z_mm / grid.intrinsics.fx;
  const int half = std::max(2, static_cast<int>(kHalfMm / cell_mm));
  TrunkShape shape;
  float edges = 0;
  float between = 0;
  for (int r = std::max(0, r_first); r <= std::min(r_last, grid.height - 1); ++r) {
    const auto inside = [&](int col) {
      if (col < 0 || col >= grid.width) return false;
      const auto i = at(grid.index(col, r));
      return labels_[i] == label && std::fabs(static_cast<float>(grid.depth[i]) - z_mm) < kDepthMm;
    };
    if (!inside(c)) continue;
    int lo = c;
    int hi = c;
    while (c - lo < half && inside(lo - 1)) --lo;
    while (hi - c < half && inside(hi + 1)) ++hi;
    const int width = hi - lo + 1;
    if (width < kWidthMinCells) continue;
    const int part = std::max(1, width / 6);
    const auto mean = [&](int first) {
      int sum = 0;
      for (int i = 0; i < part; ++i) sum += grid.depth[at(grid.index(first + i, r))];
      return static_cast<float>(sum) / static_cast<float>(part);
    };
    const float middle = mean(lo + (width - part) / 2);
    edges += 0.5F * (mean(lo) + mean(hi + 1 - part)) - middle;
    between += 0.5F * (mean(lo + (width - part) / 4) + mean(hi + 1 - part - (width - part) / 4)) - middle;
    ++shape.row_count;
  }
  if (shape.row_count == 0) return shape;
  // Edge behind the points half way, and behind the middle.
  shape.bulge_mm = edges / static_cast<float>(shape.row_count);
  shape.edge_mm = (edges - between) / static_cast<float>(shape.row_count);
  return shape;
}

// 0 for most people, above 1 for most of what is none. Trunks of people are 18..80 mm deep over their width and
// rounder than an edge seen from before (whose sides are straight) or a step; fronts of furniture are flat.
float BlobFinder::trunk_misfit(const TrunkShape& shape) {
  if (shape.row_count < kRowsMin) return kUnknownMisfit;
  const float share = shape.bulge_mm > 1.0F ? shape.edge_mm / shape.bulge_mm : kFlatShare;
  const float flat = std::max(0.0F, (kBulgeMinMm - shape.bulge_mm) / kBulgeMinSpreadMm);
  const float deep = std::max(0.0F, (shape.bulge_mm - kBulgeMaxMm) / kBulgeMaxSpreadMm);
  const float straight = std::max(0.0F, (kEdgeShareMin - share) / kEdgeShareMinSpread);
  const float stepped = std::max(0.0F, (share - kEdgeShareMax) / kEdgeShareMaxSpread);
  return flat + deep + straight + stepped;
}

// Below the middle, rows of one or two runs (1.4 to 2.35 on average), as wide as legs and as round: of 57 people
// without a clear head 47, of 240 pieces of furniture of a person's size 2.
bool BlobFinder::has_legs(const Grid& grid, int b) const {
  const Blob& blob = blobs_[at(b)];
  const auto label = static_cast<std::uint16_t>(b + 1);
  const int tall = blob.r_max - blob.r_min + 1;
  int row_count = 0;
  int run_count = 0;
  int widest_sum = 0;
  int round_count = 0;
  float bulge_sum = 0;
  for (int r = blob.r_min + tall * 68 / 100; r < blob.r_min + tall * 92 / 100; ++r) {
    int widest = 0;
    int run = 0;
    for (int c = blob.c_min; c <= blob.c_max + 1; ++c) {
      if (c <= blob.c_max && labels_[at(grid.index(c, r))] == label) {
        ++run;
        continue;
      }
      widest = std::max(widest, run);
      run_count += run > 1 ? 1 : 0;
      if (run >= kLegCellsMin) {
        const auto z = [&](int col) { return static_cast<float>(grid.depth[at(grid.index(col, r))]); };
        const int lo = c - run;
        bulge_sum += 0.5F * (z(lo) + z(c - 1)) - 0.5F * (z(lo + run / 2) + z(lo + (run - 1) / 2));
        ++round_count;
      }
      run = 0;
    }
    widest_sum += widest;
    ++row_count;
  }
  if (row_count < kRowsMin || round_count < 2 * kRowsMin) return false;
  const auto rows = static_cast<float>(row_count);
  const float cell_mm = static_cast<float>(grid.step) * blob.centroid_mm.z / grid.intrinsics.fx;
  const float runs = static_cast<float>(run_count) / rows;
  const float wide_mm = static_cast<float>(widest_sum) / rows * cell_mm;
  const float bulge_mm = bulge_sum / static_cast<float>(round_count);
  return runs >= kLegRunsMin && runs <= kLegRunsMax && wide_mm >= kLegWideMinMm && wide_mm <= kLegWideMaxMm &&
         bulge_mm >= kLegBulgeMinMm && bulge_mm <= kLegBulgeMaxMm;
}

}  // namespace im2fit::segment
