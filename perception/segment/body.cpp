// SPDX-License-Identifier: Apache-2.0
// Bodies without a head to be seen: arms raised before it, in profile, bent. People are round all over; furniture is
// made of planes, and what of it is round is so about one axis or at an edge only.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "perception/segment/blobs.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [round] came with turned and bent people: of 200 people 98.4 % found before, 99.8 % after (turned 88.2 and
//           98.5), all changes together (commit 5651a96)
//   [odds]  the range a logistic regression was fitted on, or its coefficients: 1,100 furnished rooms without
//           people, 1,180 people (commit f771803); figures: docs/tracker-evaluation.md
//   [slim]  came with people in profile: NO_PERSON instead of NOT_FRONTAL in 7 of 100 before, 3 after, all
//           changes together (commit a94b161)
//   [calm]   came with people found without a floor: of 206 calm starts of real people without a floor 28 % were
//            no one before, 0 % after (tests/real_people)
namespace im2fit::segment::body_limits {

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

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

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
  const float mm = static_cast<float>(grid.step) * blob.centroid_mm.z / grid.intrinsics.fx;
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

BlobFinder::Roundness BlobFinder::roundness(const Grid& grid, int b, int row_last) const {
  const Blob& blob = blobs_[at(b)];
  const auto label = static_cast<std::uint16_t>(b + 1);
  const Bulges across = bulges_of(grid, labels_, blob, label, row_last, false);
  const Bulges along = bulges_of(grid, labels_, blob, label, row_last, true);
  Roundness round;
  round.share = static_cast<float>(kRunCells * across.total()) / static_cast<float>(blob.cell_count);
  round.sides_mm = across.quantile(75);
  round.score = across.quantile(50) + kAlongWeight * along.quantile(50) + kAlongUpperWeight * along.quantile(75);
  return round;
}

bool BlobFinder::round_body(const Grid& grid, int b, const FloorPlane& floor) const {
  const Blob& blob = blobs_[at(b)];
  const float mm = static_cast<float>(grid.step) * blob.centroid_mm.z / grid.intrinsics.fx;
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
  if (floats(grid, b, floor) || on_pole(grid, b, floor)) return false;
  const Roundness round = roundness(grid, b, blob.r_max);
  const bool even = round.share > kBodyShareMin && round.share < kBodyShareMax && round.sides_mm > kBodySidesMinMm &&
                    round.sides_mm < kBodySidesMaxMm;
  return even && round.score + (has_legs(grid, b) ? kLegsBonus : 0.0F) >= kBodyRoundMin;
}

// A logistic regression on 1,100 furnished rooms without people and 1,180 people (calm, free, turned by 40 to 80
// degrees, bent by 28 to 50, seated; whole in the picture, some of them from anywhere), weighed with their joints'
// person_score (perception/segment/person_tracker.cpp). Slender blobs may be rounder since people in profile were
// tried. Known only of blobs that are whole, on the floor and of a person's size. Without a floor (masked
// backgrounds, black carpets, glossy tiles) a blob is taken to stand on its lowest point. How well:
// docs/tracker-evaluation.md.
float BlobFinder::shape_odds(const Grid& grid, int b, const FloorPlane& floor) const {
  const Blob& blob = blobs_[at(b)];
  const float mm = static_cast<float>(grid.step) * blob.centroid_mm.z / grid.intrinsics.fx;
  const float wide = static_cast<float>(blob.c_max - blob.c_min + 1) * mm;
  const float low = floor.known ? blob.height_min_mm : 0.0F;
  const float top = floor.known ? blob.height_max_mm : blob.height_max_mm - blob.height_min_mm;
  const int box = (blob.c_max - blob.c_min + 1) * (blob.r_max - blob.r_min + 1);
  const float fill = static_cast<float>(blob.cell_count) / static_cast<float>(box);
  const bool cut_off = !floor.known && blob.r_max >= grid.height - 2;
  const bool whole = top > (cut_off ? kCutOffTallMinMm : kWholeTopMinMm) && low < kWholeLowMaxMm;
  const bool sized = blob.area_m2 > kWholeAreaMinM2 && blob.area_m2 < kWholeAreaMaxM2 && wide > kWholeWideMinMm &&
                     fill < kWholeFillMax && blob.centroid_mm.z > kWholeNearMm && blob.centroid_mm.z < kBodyFarMm;
  if (!whole || !sized || floats(grid, b, floor)) return kShapeUnknown;
  const bool legs = has_legs(grid, b);
  const Roundness round = roundness(grid, b, blob.r_max);
  // Arms held out widen the box.
  const float fill_min = wide > kArmsOutWideMm ? kArmsOutFillMin : kWholeLeglessFillMin;
  if (!legs && (top < kWholeLeglessTopMinMm || fill < fill_min)) return kShapeUnknown;
  if (round.share < kWholeShareMin) return kShapeUnknown;
  const auto above = [](float value, float limit) { return std::max(0.0F, value - limit); };
  const auto below = [](float value, float limit) { return std::max(0.0F, limit - value); };
  float odds = -2.0F + 0.16F * std::clamp(round.score, -5.0F, 40.0F) - 0.0018F * wide;
  odds += on_pole(grid, b, floor) ? -2.6F : legs ? 3.0F : 0.0F;
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
