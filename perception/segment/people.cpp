// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "perception/segment/blobs.h"

namespace im2fit::segment {
namespace {

constexpr float kShinLowMm = 200.0F;  // above the floor
constexpr float kThighMm = 900.0F;
constexpr float kHangsFarMm = 3300.0F;  // beyond, depth steps make coats round: who is that far must be seen to stand
constexpr float kPoleMm = 50.0F;        // thick at most, with its edges; calves one behind the other are 65
constexpr float kPoleCells = 1.2F;
constexpr float kPoleMaxMm = 80.0F;
constexpr float kTrunkMisfitMax = 0.5F;
constexpr float kHeadRoundMin = 6.0F;       // of the whole or, where furniture hangs on it, the upper half
constexpr float kShapeRoundMin = 14.0F;     // of 274 people without a head 99 % are above
constexpr float kCutRoundMin = 8.0F;        // of trunks cut off above: coats against the border are below 6
constexpr float kShapeFarMm = 4000.0F;      // beyond, a disparity step is as deep as a leg is round
constexpr float kCandidateOddsMin = -5.0F;  // bent people in gowns have -3; the joints tell
constexpr float kTrunkBulgeMinMm = 5.0F;
constexpr float kTrunkBulgeMaxMm = 110.0F;

float cell_mm(const Grid& grid, float z) {
  return static_cast<float>(grid.step) * z / grid.intrinsics.fx;
}

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

// Ends in the air with only farther things below: a coat, a picture on the wall. A person's legs may be hidden by
// something nearer.
bool BlobFinder::floats(const Grid& grid, int b, const FloorPlane& floor) const {
  const Blob& blob = blobs_[at(b)];
  if (!floor.known || blob.height_min_mm < kFloatingMm || blob.r_max >= grid.height - 2) return false;
  const auto label = static_cast<std::uint16_t>(b + 1);
  int hidden = 0;
  int open = 0;
  for (int c = blob.c_min; c <= blob.c_max; ++c) {
    int r = blob.r_max;
    while (r >= blob.r_min && labels_[at(grid.index(c, r))] != label) --r;
    if (r < blob.r_min || r + 3 >= grid.height) continue;
    const float z = static_cast<float>(grid.depth[at(grid.index(c, r))]);
    float below = 0;
    for (int d = 1; d <= 3 && below == 0; ++d) below = static_cast<float>(grid.depth[at(grid.index(c, r + d))]);
    (below > 0 && below < z + 0.5F * depth_step_mm(z) ? hidden : open) += 1;
  }
  return hidden < open;
}

// Stands on something thinner than a leg.
bool BlobFinder::on_pole(const Grid& grid, int b, const FloorPlane& floor) const {
  const Blob& blob = blobs_[at(b)];
  if (!floor.known || blob.height_min_mm > kShinLowMm) return false;
  const auto label = static_cast<std::uint16_t>(b + 1);
  const float thin_mm = std::min(kPoleMaxMm, kPoleMm + kPoleCells * cell_mm(grid, blob.centroid_mm.z));
  int thin_rows = 0;  // in succession
  for (int r = blob.r_min; r <= blob.r_max; ++r) {
    // The whole row's width: cut at a height, the slanting edge of a thigh would look thin.
    float width = 0;
    bool low = false;
    for (int c = blob.c_min; c <= blob.c_max; ++c) {
      const auto cell = at(grid.index(c, r));
      if (labels_[cell] != label) continue;
      low = low || (grid.height_mm[cell] > kShinLowMm && grid.height_mm[cell] < kThighMm);
      width += cell_mm(grid, static_cast<float>(grid.depth[cell]));
    }
    thin_rows = low && width < thin_mm ? thin_rows + 1 : 0;
    if (thin_rows == 3) return true;
  }
  return false;
}

void BlobFinder::judge(const Grid& grid, const FloorPlane& floor) {
  bool any_head = false;
  for (const bool vague : {false, true}) {
    if (any_head) break;
    for (int h = 0; h < head_count_; ++h) {
      if (heads_[at(h)].vague != vague || !heads_[at(h)].seen) continue;
      const int b = heads_[at(h)].blob;
      Blob& blob = blobs_[at(b)];
      const float tall = blob.height_max_mm - blob.height_min_mm;
      const bool sized = blob.area_m2 > 0.06F && blob.area_m2 < kPersonAreaMaxM2 && tall > 300.0F;
      const bool hangs = floor.known && blob.height_min_mm > kFloatingMm && blob.centroid_mm.z > kHangsFarMm;
      if (!sized || hangs || floats(grid, b, floor) || on_pole(grid, b, floor)) continue;
      const int middle = blob.r_min + (blob.r_max - blob.r_min) / 2;
      if (roundness(grid, b, middle).score < kHeadRoundMin && roundness(grid, b, blob.r_max).score < kHeadRoundMin)
        continue;
      blob.person = blob.has_head = true;
      blob.head_mm = heads_[at(h)].top_mm;
      any_head = true;
    }
  }
  for (int b = 0; b < blob_count_; ++b) {
    Blob& blob = blobs_[at(b)];
    if (blob.person || blob.cell_count == 0) continue;
    blob.person_sized = person_sized(grid, blob, floor);
    blob.person = (blob.person_sized && person_shaped(grid, b)) || round_body(grid, b, floor);
  }
  for (int b = 0; b < blob_count_; ++b) {
    Blob& blob = blobs_[at(b)];
    blob.shape_odds = shape_odds(grid, b, floor);
    blob.candidate = !blob.person && blob.shape_odds >= kCandidateOddsMin;
  }
}

// Where a trunk would be, about the middle of what is there.
BlobFinder::TrunkShape BlobFinder::trunk_of(const Grid& grid, int b) const {
  const Blob& blob = blobs_[at(b)];
  const int tall = blob.r_max - blob.r_min + 1;
  const float z = blob.centroid_mm.z;
  const float u = blob.centroid_mm.x / z * grid.intrinsics.fx + grid.intrinsics.cx;
  const int c = std::clamp(static_cast<int>(u / static_cast<float>(grid.step)), 0, grid.width - 1);
  return trunk_shape(grid, b, c, blob.r_min + tall / 4, blob.r_min + tall / 2, z);
}

// Of those without a head: furniture has a person's size and relief, but neither trunk nor legs. Who is cut off above
// and below has no legs to show; what is cut off at a side as well may be anything.
bool BlobFinder::person_shaped(const Grid& grid, int b) const {
  const Blob& blob = blobs_[at(b)];
  if (blob.centroid_mm.z > kShapeFarMm) return false;
  const float round = roundness(grid, b, blob.r_max).score;
  if (round < kCutRoundMin) return false;
  const TrunkShape trunk = trunk_of(grid, b);
  if (has_legs(grid, b) && round > kShapeRoundMin)
    return trunk.bulge_mm > kTrunkBulgeMinMm && trunk.bulge_mm < kTrunkBulgeMaxMm;
  const bool inside = blob.c_min > 1 && blob.c_max < grid.width - 2;
  return blob.r_min <= 1 && inside && trunk_misfit(trunk) < kTrunkMisfitMax;
}

// Heads cut off by the upper border, or hidden by raised arms: person-sized, neither flat nor filling its box.
bool BlobFinder::person_sized(const Grid& grid, const Blob& blob, const FloorPlane& floor) {
  const float mm = cell_mm(grid, blob.centroid_mm.z);
  const float wide = static_cast<float>(blob.c_max - blob.c_min + 1) * mm;
  const float tall = blob.height_max_mm - blob.height_min_mm;
  const int box = (blob.c_max - blob.c_min + 1) * (blob.r_max - blob.r_min + 1);
  const bool top_cut = blob.r_min <= 1;
  const float fill = static_cast<float>(blob.cell_count) / static_cast<float>(box);
  const float relief_min = 14.0F + 0.5F * quantum_mm(blob.centroid_mm.z);
  const bool stands = !floor.known || blob.height_min_mm < 250.0F || blob.r_max >= grid.height - 2;
  if (blob.relief_mm < relief_min || blob.relief_mm > 220.0F || !stands) return false;
  if (top_cut)
    return tall > 600.0F && wide > 250.0F && wide < 1500.0F && blob.area_m2 > 0.18F && blob.area_m2 < 1.6F &&
           fill < 0.86F && fill > 0.25F;
  return tall > 1250.0F && tall < 2500.0F && wide > 250.0F && wide < 1700.0F && blob.area_m2 > 0.22F &&
         blob.area_m2 < 1.3F && fill < 0.72F && fill > 0.18F;
}

}  // namespace im2fit::segment
