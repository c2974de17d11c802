// SPDX-License-Identifier: Apache-2.0
// Which surfaces are people, by a head, by roundness or by size.
#include <algorithm>
#include <cmath>

#include "perception/segment/blobs.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [empty] came with fewer false users: of 10,000 empty frames 226 before, 54 after, all changes together
//           (commit 3db21d5)
//   [round] came with round trunks and legs: of 1,000 empty frames 436 showed a user before, 3 after; all
//           changes together (commit 1e3516a)
//   [odds]  came with the shape's log-odds, for bent people in gowns (commit a94b161;
//           docs/tracker-evaluation.md)
//   [rooms] chosen on synthetic rooms, no measurement on record
namespace im2fit::segment::people_limits {

// What floats or stands.
constexpr float kHangsFarMm = 3300.0F;  // beyond, disparity steps make coats round: legs must be seen; [empty]
constexpr float kLowMaxMm = 250.0F;     // above the floor: what ends lower stands; [rooms]

// A surface with a head.
constexpr float kHeadedAreaMinM2 = 0.06F;   // area, least; [rooms]
constexpr float kHeadedTallMinMm = 300.0F;  // height, least; [rooms]
constexpr float kHeadRoundMin =
    6.0F;  // roundness of the whole, or of the upper half where furniture hangs on it (commit 5651a96)

// A surface without one, by its roundness.
constexpr float kShapeRoundMin =
    14.0F;  // roundness above legs; of 274 people without a head 99 % are above (commit 5651a96)
constexpr float kCutRoundMin =
    8.0F;  // of trunks cut off above; coats against the border are below 6 (commit 5651a96)
constexpr float kShapeFarMm = 4000.0F;      // beyond, a disparity step is as deep as a leg is round; [round]
constexpr float kTrunkBulgeMinMm = 5.0F;    // of the trunk above legs, least; [round]
constexpr float kTrunkBulgeMaxMm = 110.0F;  // and most; [round]
constexpr float kTrunkMisfitMax = 0.5F;     // of a trunk cut off above and below; [round]
constexpr float kCandidateOddsMin = -5.0F;  // log-odds of a candidate, least; bent people in gowns have -3; [odds]

// A surface without one, by its size.
constexpr float kReliefMinMm = 14.0F;       // from its best plane, least; [rooms]
constexpr float kReliefQuanta = 0.5F;       // and so many disparity steps; [rooms]
constexpr float kReliefMaxMm = 220.0F;      // most; [rooms]
constexpr float kWideMinMm = 250.0F;        // width, least; [rooms]
constexpr float kCutTallMinMm = 600.0F;     // cut off above: height, least; [rooms]
constexpr float kCutWideMaxMm = 1500.0F;    // width, most; [rooms]
constexpr float kCutAreaMinM2 = 0.18F;      // area, least; [rooms]
constexpr float kCutAreaMaxM2 = 1.6F;       // and most; [rooms]
constexpr float kCutFillMin = 0.25F;        // of its box, least; [rooms]
constexpr float kCutFillMax = 0.86F;        // and most; [rooms]
constexpr float kWholeTallMinMm = 1250.0F;  // whole: height, least; [rooms]
constexpr float kWholeTallMaxMm = 2500.0F;  // and most; [rooms]
constexpr float kWholeWideMaxMm = 1700.0F;  // width, most: arms held out; [rooms]
constexpr float kWholeAreaMinM2 = 0.22F;    // area, least; [rooms]
constexpr float kWholeAreaMaxM2 = 1.3F;     // and most; [rooms]
constexpr float kWholeFillMin = 0.18F;      // of its box, least; [rooms]
constexpr float kWholeFillMax = 0.72F;      // and most; [rooms]

}  // namespace im2fit::segment::people_limits

namespace im2fit::segment {

using namespace people_limits;

namespace {

// Where a trunk would be, about the middle of what is there.
TrunkShape trunk_of(const Grid& grid, const Blobs& found, int b) {
  const Blob& blob = found.blobs[at(b)];
  const int tall = blob.r_max - blob.r_min + 1;
  const float z = blob.centroid_mm.z;
  const float u = blob.centroid_mm.x / z * grid.intrinsics.fx + grid.intrinsics.cx;
  const int c = std::clamp(static_cast<int>(u / static_cast<float>(grid.step)), 0, grid.width - 1);
  return trunk_shape(grid, found.labels, b, c, blob.r_min + tall / 4, blob.r_min + tall / 2, z);
}

// For blobs without a head: furniture has a person's size and relief, but neither trunk nor legs. A body cut off
// above and below shows no legs; a blob cut off at a side as well may be anything.
bool person_shaped(const Grid& grid, const Blobs& found, int b) {
  const Blob& blob = found.blobs[at(b)];
  if (blob.centroid_mm.z > kShapeFarMm) return false;
  const float round = roundness(grid, found, b, blob.r_max).score;
  if (round < kCutRoundMin) return false;
  const TrunkShape trunk = trunk_of(grid, found, b);
  if (has_legs(grid, found, b) && round > kShapeRoundMin)
    return trunk.bulge_mm > kTrunkBulgeMinMm && trunk.bulge_mm < kTrunkBulgeMaxMm;
  const bool inside = blob.c_min > 1 && blob.c_max < grid.width - 2;
  return blob.r_min <= 1 && inside && trunk_misfit(trunk) < kTrunkMisfitMax;
}

// Heads cut off by the upper border, or hidden by raised arms: person-sized, neither flat nor filling its box.
bool person_sized(const Grid& grid, const Blob& blob, const FloorPlane& floor) {
  const float mm = cell_mm(grid, blob.centroid_mm.z);
  const float wide = static_cast<float>(blob.c_max - blob.c_min + 1) * mm;
  const float tall = blob.height_max_mm - blob.height_min_mm;
  const int box = (blob.c_max - blob.c_min + 1) * (blob.r_max - blob.r_min + 1);
  const bool top_cut = blob.r_min <= 1;
  const float fill = static_cast<float>(blob.cell_count) / static_cast<float>(box);
  const float relief_min = kReliefMinMm + kReliefQuanta * quantum_mm(blob.centroid_mm.z);
  const bool stands = !floor.known || blob.height_min_mm < kLowMaxMm || blob.r_max >= grid.height - 2;
  if (blob.relief_mm < relief_min || blob.relief_mm > kReliefMaxMm || !stands) return false;
  if (top_cut)
    return tall > kCutTallMinMm && wide > kWideMinMm && wide < kCutWideMaxMm && blob.area_m2 > kCutAreaMinM2 &&
           blob.area_m2 < kCutAreaMaxM2 && fill < kCutFillMax && fill > kCutFillMin;
  return tall > kWholeTallMinMm && tall < kWholeTallMaxMm && wide > kWideMinMm && wide < kWholeWideMaxMm &&
         blob.area_m2 > kWholeAreaMinM2 && blob.area_m2 < kWholeAreaMaxM2 && fill < kWholeFillMax &&
         fill > kWholeFillMin;
}

}  // namespace

void judge_blobs(const Grid& grid, const FloorPlane& floor, Blobs& found) {
  bool any_head = false;
  for (const bool vague : {false, true}) {
    if (any_head) break;
    for (int h = 0; h < found.head_count; ++h) {
      if (found.heads[at(h)].vague != vague || !found.heads[at(h)].seen) continue;
      const int b = found.heads[at(h)].blob;
      Blob& blob = found.blobs[at(b)];
      const float tall = blob.height_max_mm - blob.height_min_mm;
      const bool sized =
          blob.area_m2 > kHeadedAreaMinM2 && blob.area_m2 < kPersonAreaMaxM2 && tall > kHeadedTallMinMm;
      const bool hangs = floor.known && blob.height_min_mm > kFloatingMm && blob.centroid_mm.z > kHangsFarMm;
      if (!sized || hangs || floats(grid, floor, found, b) || on_pole(grid, floor, found, b)) continue;
      const int middle = blob.r_min + (blob.r_max - blob.r_min) / 2;
      if (roundness(grid, found, b, middle).score < kHeadRoundMin &&
          roundness(grid, found, b, blob.r_max).score < kHeadRoundMin)
        continue;
      blob.person = blob.has_head = true;
      blob.head_mm = found.heads[at(h)].top_mm;
      any_head = true;
    }
  }
  for (int b = 0; b < found.blob_count; ++b) {
    Blob& blob = found.blobs[at(b)];
    if (blob.person || blob.cell_count == 0) continue;
    blob.person_sized = person_sized(grid, blob, floor);
    blob.person = (blob.person_sized && person_shaped(grid, found, b)) || round_body(grid, floor, found, b);
  }
  for (int b = 0; b < found.blob_count; ++b) {
    Blob& blob = found.blobs[at(b)];
    blob.shape_odds = shape_odds(grid, floor, found, b);
    blob.candidate = !blob.person && blob.shape_odds >= kCandidateOddsMin;
  }
}

}  // namespace im2fit::segment
