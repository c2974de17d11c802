// SPDX-License-Identifier: Apache-2.0
// The shape of one surface: how round trunks, legs and whole bodies are, what floats or stands on a pole, and the
// odds that a person has such a shape. People are round all over; furniture is made of planes, and what of it is
// round is so about one axis or at an edge only. Bodies without a head to be seen have their arms raised before it,
// or stand in profile or bent.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "perception/segment/blobs.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [legs]  of 57 people without a clear head 47 have such legs, of 240 pieces of furniture of a person's size
//           2 (commit 1e3516a)
//   [trunk] came with commit 1e3516a: of 1,000 empty frames 436 showed a user before, 3 after; all changes
//           together
//   [coats] excludes coats on stands (commit 78a99e4): chosen on synthetic rooms, no measurement on record
//   [empty] came with fewer false users: of 10,000 empty frames 226 before, 54 after, all changes together
//           (commit 3db21d5)
//   [rooms] chosen on synthetic rooms, no measurement on record
//   [round] came with turned and bent people: of 200 people 98.4 % found before, 99.8 % after (turned 88.2 and
//           98.5), all changes together (commit 5651a96)
//   [odds]  the range a logistic regression was fitted on, or its coefficients: 1,100 furnished rooms without
//           people, 1,180 people (commit f771803); figures: docs/tracker-evaluation.md
//   [slim]  came with people in profile: NO_PERSON instead of NOT_FRONTAL in 7 of 100 before, 3 after, all
//           changes together (commit a94b161)
//   [calm]   came with people found without a floor: of 206 calm starts of real people without a floor 28 % were
//            no one before, 0 % after (tests/real_people)
namespace im2fit::segment::body_limits {

// Trunks: the bulge of their rows.
constexpr float kHalfMm = 180.0F;   // of a row, either side of the middle, most; [coats]
constexpr float kDepthMm = 280.0F;  // from the depth given: still the same surface; [trunk]
constexpr int kWidthMinCells = 6;   // of a row, least; [trunk]
constexpr int kRowsMin = 8;         // of a trunk or of legs, least: a disparity step of 20 mm then leaves 3; [trunk]
constexpr float kUnknownMisfit = 2.0F;        // of fewer rows; [trunk]
constexpr float kFlatShare = 2.0F;            // edge over bulge, of a bulge below 1 mm; [trunk]
constexpr float kBulgeMinMm = 18.0F;          // people have 18 to 80; [trunk]
constexpr float kBulgeMinSpreadMm = 8.0F;     // a misfit of 1 below that; [trunk]
constexpr float kBulgeMaxMm = 80.0F;          // and most; [trunk]
constexpr float kBulgeMaxSpreadMm = 30.0F;    // a misfit of 1 above that; [trunk]
constexpr float kEdgeShareMin = 0.58F;        // of the bulge, beyond half way: below, sides are straight; [trunk]
constexpr float kEdgeShareMinSpread = 0.2F;   // a misfit of 1 below that; [trunk]
constexpr float kEdgeShareMax = 0.93F;        // above, there is a step; [trunk]
constexpr float kEdgeShareMaxSpread = 0.08F;  // a misfit of 1 above that; [trunk]

// Legs: rows of the lower part.
constexpr float kLegWideMinMm = 80.0F;   // widest run of a row, mean, least; [legs]
constexpr float kLegWideMaxMm = 240.0F;  // and most, with trousers; [legs]
constexpr float kLegBulgeMinMm = 17.0F;  // middle before the edges, mean, least; [legs]
constexpr float kLegBulgeMaxMm = 75.0F;  // and most; [legs]
constexpr int kLegCellsMin = 4;          // of a row across a leg, to see it round; [legs]
constexpr float kLegRunsMin = 1.4F;      // runs of a row, mean, least: one leg or two; [legs]
constexpr float kLegRunsMax = 2.35F;     // and most; [legs]

// Poles.
constexpr float kShinLowMm = 200.0F;  // above the floor: shins are seen from here; [rooms]
constexpr float kThighMm = 900.0F;    // to here, thighs; [rooms]
constexpr float kPoleMm = 50.0F;      // width of a pole, most; calves one behind the other have 65; [empty]
constexpr float kPoleCells = 1.2F;    // and so many cells, for its edges; [empty]
constexpr float kPoleMaxMm = 80.0F;   // but never more; [empty]
constexpr int kPoleRows = 3;          // so many rows in succession; [empty]

// How round a surface is.
constexpr float kBaseMm =
    70.0F;  // either side of a point: less than a thigh is wide, more than depth noise hides; [round]
constexpr int kStepMaxMm = 150;            // to the points at the sides: no outline between; [round]
constexpr int kRunCells = 4;               // averaged along the other axis; [round]
constexpr int kBinZero = 128;              // bin of a bulge of 0: half of the bins
constexpr int kBinCount = 256;             // of 1 mm, from -kBinZero: bulges beyond count as the last
constexpr float kAlongWeight = 4.0F;       // median along, in units of that across; [round]
constexpr float kAlongUpperWeight = 0.3F;  // upper quartile along; [round]

// A body without a head to be seen.
constexpr float kBodyFarMm = 4000.0F;       // beyond, disparity steps are as deep as a body is round; [round]
constexpr float kBodyTallMinMm = 900.0F;    // height, least; [round]
constexpr float kBodyTopMinMm = 1000.0F;    // top above the floor, least; [round]
constexpr float kBodyTopMaxMm = 2200.0F;    // and most; [round]
constexpr float kBodyLowMaxMm = 250.0F;     // lower end above the floor, most; [round]
constexpr float kBodyReliefMaxMm = 180.0F;  // from its best plane, most; [round]
constexpr float kBodyWideMinMm = 250.0F;    // width, least; [round]
constexpr float kBodyAreaMinM2 = 0.28F;     // area, least; [round]
constexpr float kBodyAreaMaxM2 = 0.95F;     // and most; [round]
constexpr float kBodyFillMax = 0.7F;        // of its box, most; [round]
constexpr float kBodyShareMin = 0.1F;       // cells with the surface on both sides, least; [round]
constexpr float kBodyShareMax = 0.6F;       // and most; [round]
constexpr float kBodySidesMinMm = 14.0F;    // bulge of the rounder quarter, least; [round]
constexpr float kBodySidesMaxMm = 45.0F;    // and most; [round]
constexpr float kBodyRoundMin = 28.0F;      // score, least; [round]
constexpr float kLegsBonus = 10.0F;         // of the score, for legs; [round]

// What has log-odds at all: whole, on the floor, of a person's size.
constexpr float kWholeTopMinMm = 1000.0F;         // top above the floor, least; [odds]
constexpr float kWholeLeglessTopMinMm = 1150.0F;  // the same without legs; [odds]
constexpr float kCutOffTallMinMm =
    1250.0F;  // of what is cut off below and stands on no known floor, its height, least: as FEET_CUT's; [calm]
constexpr float kWholeWideMinMm = 240.0F;     // width, least; [odds]
constexpr float kWholeLowMaxMm = 420.0F;      // lower end above the floor, most; [odds]
constexpr float kWholeNearMm = 1100.0F;       // distance, least; [odds]
constexpr float kWholeAreaMinM2 = 0.15F;      // area, least; [odds]
constexpr float kWholeAreaMaxM2 = 1.1F;       // and most; [odds]
constexpr float kWholeFillMax = 0.75F;        // of its box, most; [odds]
constexpr float kWholeLeglessFillMin = 0.3F;  // and least, without legs; [odds]
constexpr float kArmsOutWideMm = 1000.0F;     // wider than that the arms are out, if it is a person; [calm]
constexpr float kArmsOutFillMin = 0.15F;      // of the box, least, then; a real person had 0.23; [calm]
constexpr float kWholeShareMin = 0.02F;       // cells with the surface on both sides, least; [odds]
constexpr float kSlenderWideMm = 370.0F;  // narrower: in profile, rounder at the sides than from the front; [slim]
constexpr float kSlenderRoundMax = 1.5F;  // of log-odds, most that being so costs; [slim]
constexpr float kOddsMax = 9.0F;          // log-odds either way, most; [odds]

}  // namespace im2fit::segment::body_limits

namespace im2fit::segment {

using namespace body_limits;

namespace {

// How far the middle of a stretch of 2 x kBaseMm lies before its ends, over a blob.
class Bulges {
 public:
  void add(int bulge_mm) {
    ++count_[at(std::clamp(bulge_mm + kBinZero, 0, kBinCount - 1))];
    ++total_;
  }
  int total() const { return total_; }
  float quantile(int percent) const {
    const int wanted = total_ * percent / 100;
    int below = 0;
    for (int bin = 0; bin < kBinCount; ++bin) {
      below += count_[at(bin)];
      if (below > wanted) return static_cast<float>(bin - kBinZero);
    }
    return 0;
  }

 private:
  std::array<int, kBinCount> count_{};
  int total_ = 0;
};

// Samples where the blob goes on at either side; averages of four cells in a row across the axis.
Bulges bulges_of(const Grid& grid, std::span<const std::uint16_t> labels, const Blob& blob, std::uint16_t label,
                 int row_last, bool upright) {
  const float mm = cell_mm(grid, blob.centroid_mm.z);
  const int reach = std::max(2, static_cast<int>(kBaseMm / mm + 0.5F));
  Bulges bulges;
  const int side = upright ? reach * grid.width : reach;
  const int c_in = upright ? 0 : reach;
  const int r_in = upright ? reach : 0;
  const auto sample = [&](int cell, int& twice_mm) {
    if (labels[at(cell)] != label || labels[at(cell - side)] != label || labels[at(cell + side)] != label)
      return false;
    const int z = grid.depth[at(cell)];
    const int before = grid.depth[at(cell - side)] - z;
    const int after = grid.depth[at(cell + side)] - z;
    twice_mm = before + after;
    return std::abs(before) < kStepMaxMm && std::abs(after) < kStepMaxMm;
  };
  const auto walk = [&](int first, int last, int stride) {
    int run = 0;
    int sum = 0;
    for (int cell = first; cell <= last; cell += stride) {
      int twice_mm = 0;
      if (!sample(cell, twice_mm)) {
        run = sum = 0;
        continue;
      }
      sum += twice_mm;
      if (++run < kRunCells) continue;
      bulges.add((sum + kRunCells + 2 * kRunCells * 1024) / (2 * kRunCells) - 1024);  // rounds down below zero too
      run = sum = 0;
    }
  };
  const int c_first = blob.c_min + c_in;
  const int c_last = blob.c_max - c_in;
  const int r_first = blob.r_min + r_in;
  const int r_last = std::min(blob.r_max - r_in, row_last);
  if (upright) {
    for (int r = r_first; r <= r_last; ++r) walk(grid.index(c_first, r), grid.index(c_last, r), 1);
  } else {
    for (int c = c_first; c <= c_last; ++c) walk(grid.index(c, r_first), grid.index(c, r_last), grid.width);
  }
  return bulges;
}

}  // namespace

// Rows r_first..r_last about column c: how far the edges lie behind the middle on average, and the points half way
// behind the middle. Averages over sixths of a row and all rows: a disparity step of 20 mm leaves 3.
TrunkShape trunk_shape(const Grid& grid, std::span<const std::uint16_t> labels, int blob, int c, int r_first,
                       int r_last, float z_mm) {
  const auto label = static_cast<std::uint16_t>(blob + 1);
  const float mm = cell_mm(grid, z_mm);
  const int half = std::max(2, static_cast<int>(kHalfMm / mm));
  TrunkShape shape;
  float edges = 0;
  float between = 0;
  for (int r = std::max(0, r_first); r <= std::min(r_last, grid.height - 1); ++r) {
    const auto inside = [&](int col) {
      if (col < 0 || col >= grid.width) return false;
      const auto i = at(grid.index(col, r));
      return labels[i] == label && std::fabs(static_cast<float>(grid.depth[i]) - z_mm) < kDepthMm;
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
float trunk_misfit(const TrunkShape& shape) {
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
bool has_legs(const Grid& grid, const Blobs& found, int b, float scale) {
  const Blob& blob = found.blobs[at(b)];
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
      if (c <= blob.c_max && found.labels[at(grid.index(c, r))] == label) {
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
  const float mm = cell_mm(grid, blob.centroid_mm.z);
  const float runs = static_cast<float>(run_count) / rows;
  const float wide_mm = static_cast<float>(widest_sum) / rows * mm;
  const float bulge_mm = bulge_sum / static_cast<float>(round_count);
  return runs >= kLegRunsMin && runs <= kLegRunsMax && wide_mm >= scale * kLegWideMinMm && wide_mm <= kLegWideMaxMm &&
         bulge_mm >= scale * kLegBulgeMinMm && bulge_mm <= kLegBulgeMaxMm;
}

// Ends in the air with only farther things below: a coat, a picture on the wall. A person's legs may be hidden by
// something nearer.
bool floats(const Grid& grid, const FloorPlane& floor, const Blobs& found, int b) {
  const Blob& blob = found.blobs[at(b)];
  if (!floor.known || blob.height_min_mm < kFloatingMm || blob.r_max >= grid.height - 2) return false;
  const auto label = static_cast<std::uint16_t>(b + 1);
  int hidden = 0;
  int open = 0;
  for (int c = blob.c_min; c <= blob.c_max; ++c) {
    int r = blob.r_max;
    while (r >= blob.r_min && found.labels[at(grid.index(c, r))] != label) --r;
    if (r < blob.r_min || r + 3 >= grid.height) continue;
    const float z = static_cast<float>(grid.depth[at(grid.index(c, r))]);
    float below = 0;
    for (int d = 1; d <= 3 && below == 0; ++d) below = static_cast<float>(grid.depth[at(grid.index(c, r + d))]);
    (below > 0 && below < z + 0.5F * depth_step_mm(z) ? hidden : open) += 1;
  }
  return hidden < open;
}

// Stands on something narrower than a leg.
bool on_pole(const Grid& grid, const FloorPlane& floor, const Blobs& found, int b) {
  const Blob& blob = found.blobs[at(b)];
  if (!floor.known || blob.height_min_mm > kShinLowMm) return false;
  const auto label = static_cast<std::uint16_t>(b + 1);
  const float narrow_mm = std::min(kPoleMaxMm, kPoleMm + kPoleCells * cell_mm(grid, blob.centroid_mm.z));
  int narrow_rows = 0;  // in succession
  for (int r = blob.r_min; r <= blob.r_max; ++r) {
    // The whole row's width: cut at a height, the slanting edge of a thigh would be narrow.
    float width = 0;
    bool low = false;
    for (int c = blob.c_min; c <= blob.c_max; ++c) {
      const auto cell = at(grid.index(c, r));
      if (found.labels[cell] != label) continue;
      low = low || (grid.height_mm[cell] > kShinLowMm && grid.height_mm[cell] < kThighMm);
      width += cell_mm(grid, static_cast<float>(grid.depth[cell]));
    }
    narrow_rows = low && width < narrow_mm ? narrow_rows + 1 : 0;
    if (narrow_rows == kPoleRows) return true;
  }
  return false;
}

Roundness roundness(const Grid& grid, const Blobs& found, int b, int row_last) {
  const Blob& blob = found.blobs[at(b)];
  const auto label = static_cast<std::uint16_t>(b + 1);
  const Bulges across = bulges_of(grid, found.labels, blob, label, row_last, false);
  const Bulges along = bulges_of(grid, found.labels, blob, label, row_last, true);
  Roundness round;
  round.share = static_cast<float>(kRunCells * across.total()) / static_cast<float>(blob.cell_count);
  round.sides_mm = across.quantile(75);
  round.score = across.quantile(50) + kAlongWeight * along.quantile(50) + kAlongUpperWeight * along.quantile(75);
  return round;
}

bool round_body(const Grid& grid, const FloorPlane& floor, const Blobs& found, int b) {
  const Blob& blob = found.blobs[at(b)];
  const float mm = cell_mm(grid, blob.centroid_mm.z);
  const float wide = static_cast<float>(blob.c_max - blob.c_min + 1) * mm;
  const float tall = blob.height_max_mm - blob.height_min_mm;
  const int box = (blob.c_max - blob.c_min + 1) * (blob.r_max - blob.r_min + 1);
  const bool stands = !floor.known || blob.height_min_mm < kBodyLowMaxMm || blob.r_max >= grid.height - 2;
  const bool high = !floor.known || (blob.height_max_mm > kBodyTopMinMm && blob.height_max_mm < kBodyTopMaxMm);
  const bool sized = tall > kBodyTallMinMm && wide > kBodyWideMinMm && blob.area_m2 > kBodyAreaMinM2 &&
                     blob.area_m2 < kBodyAreaMaxM2 &&
                     static_cast<float>(blob.cell_count) < kBodyFillMax * static_cast<float>(box);
  if (!stands || !high || !sized || blob.relief_mm > kBodyReliefMaxMm || blob.centroid_mm.z > kBodyFarMm)
    return false;
  if (floats(grid, floor, found, b) || on_pole(grid, floor, found, b)) return false;
  const Roundness round = roundness(grid, found, b, blob.r_max);
  const bool even = round.share > kBodyShareMin && round.share < kBodyShareMax && round.sides_mm > kBodySidesMinMm &&
                    round.sides_mm < kBodySidesMaxMm;
  return even && round.score + (has_legs(grid, found, b) ? kLegsBonus : 0.0F) >= kBodyRoundMin;
}

// A logistic regression on 1,100 furnished rooms without people and 1,180 people (calm, free, turned by 40 to 80
// degrees, bent by 28 to 50, seated; whole in the picture, some of them from anywhere), weighed with their joints'
// person_score (perception/segment/person_tracker.cpp). Slender blobs may be rounder since people in profile were
// tried. Known only of blobs that are whole, on the floor and of a person's size. Without a floor (masked
// backgrounds, black carpets, glossy tiles) a blob is taken to stand on its lowest point. How well:
// docs/tracker-evaluation.md.
float shape_odds(const Grid& grid, const FloorPlane& floor, const Blobs& found, int b) {
  const Blob& blob = found.blobs[at(b)];
  const float mm = cell_mm(grid, blob.centroid_mm.z);
  const float wide = static_cast<float>(blob.c_max - blob.c_min + 1) * mm;
  const float low = floor.known ? blob.height_min_mm : 0.0F;
  const float top = floor.known ? blob.height_max_mm : blob.height_max_mm - blob.height_min_mm;
  const int box = (blob.c_max - blob.c_min + 1) * (blob.r_max - blob.r_min + 1);
  const float fill = static_cast<float>(blob.cell_count) / static_cast<float>(box);
  const bool cut_off = !floor.known && blob.r_max >= grid.height - 2;
  const bool whole = top > (cut_off ? kCutOffTallMinMm : kWholeTopMinMm) && low < kWholeLowMaxMm;
  const bool sized = blob.area_m2 > kWholeAreaMinM2 && blob.area_m2 < kWholeAreaMaxM2 && wide > kWholeWideMinMm &&
                     fill < kWholeFillMax && blob.centroid_mm.z > kWholeNearMm && blob.centroid_mm.z < kBodyFarMm;
  if (!whole || !sized || floats(grid, floor, found, b)) return kShapeUnknown;
  const bool legs = has_legs(grid, found, b);
  const Roundness round = roundness(grid, found, b, blob.r_max);
  // Arms held out widen the box.
  const float fill_min = wide > kArmsOutWideMm ? kArmsOutFillMin : kWholeLeglessFillMin;
  if (!legs && (top < kWholeLeglessTopMinMm || fill < fill_min)) return kShapeUnknown;
  if (round.share < kWholeShareMin) return kShapeUnknown;
  const auto above = [](float value, float limit) { return std::max(0.0F, value - limit); };
  const auto below = [](float value, float limit) { return std::max(0.0F, limit - value); };
  float odds = -2.0F + 0.16F * std::clamp(round.score, -5.0F, 40.0F) - 0.0018F * wide;
  odds += on_pole(grid, floor, found, b) ? -2.6F : legs ? 3.0F : 0.0F;
  const float too_round = 0.14F * above(round.sides_mm, 38.0F);
  odds -= wide < kSlenderWideMm ? std::min(too_round, kSlenderRoundMax) : too_round;
  odds -= 0.27F * below(round.sides_mm, 14.0F);
  odds -= 13.0F * below(round.share, 0.1F) + 12.0F * above(round.share, 0.45F);
  odds -= 0.01F * below(top, 1150.0F) + 0.011F * above(top, 1900.0F);
  odds -= 0.036F * above(blob.relief_mm, 110.0F);
  odds -= 0.003F * above(blob.centroid_mm.z, 3300.0F);  // where disparity steps make flat things round
  return std::clamp(odds, -kOddsMax, kOddsMax);
}

}  // namespace im2fit::segment
