// SPDX-License-Identifier: Apache-2.0
#include "kernels/segment/fragments.h"

#include <algorithm>
#include <cmath>

namespace im2fit::segment {
namespace {

constexpr float kFragmentAreaMaxM2 = 0.12F;  // a forearm pointing at the camera
constexpr float kForearmMaxMm = 600.0F;      // with the hand
constexpr float kForearmThickMinMm = 70.0F;  // table tops are thinner
constexpr float kForearmAreaMaxM2 = 0.08F;
constexpr float kHandHeightMinMm = 400.0F;  // above the floor: below it stand boxes and chairs
constexpr float kHandGapMaxMm = 280.0F;     // held towards the camera, the forearm is hidden
constexpr float kPointingMm = 250.0F;       // a hand this far before the body may hide its whole arm
constexpr float kPointingGapMaxMm = 450.0F;
constexpr float kHandMaxMm = 320.0F;
constexpr float kElbowGapMaxMm = 100.0F;
constexpr int kGapReachCells = 9;

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

FragmentJoiner::FragmentJoiner()
    : touch_(at(kBlobCountMax)),
      border_(at(kBlobCountMax)),
      gap_mm_(at(kBlobCountMax)),
      gap_max_mm_(at(kBlobCountMax)),
      candidate_(at(kBlobCountMax)) {}

void FragmentJoiner::list_candidates(const Grid& grid, std::span<const Blob> list, bool floor_known, int person) {
  const Blob& body = list[at(person)];
  for (std::size_t b = 0; b < list.size(); ++b) {
    const Blob& other = list[b];
    const float z = other.centroid_mm.z;
    const float cell = static_cast<float>(grid.step) * z / grid.intrinsics.fx;
    const bool small = other.area_m2 < kFragmentAreaMaxM2 && !other.person && b != at(person);
    candidate_[b] = small && z > body.centroid_mm.z - 900.0F && z < body.centroid_mm.z + 500.0F ? 1 : 0;
    const float reach = static_cast<float>(std::max(other.c_max - other.c_min, other.r_max - other.r_min)) * cell;
    const bool off_floor = !floor_known || other.height_min_mm > kHandHeightMinMm;
    const float before = body.centroid_mm.z - z;
    gap_max_mm_[b] = before > kPointingMm && reach < kHandMaxMm ? kPointingGapMaxMm
                     : before > 60.0F && reach < kForearmMaxMm  ? kHandGapMaxMm
                                                                : kElbowGapMaxMm;
    const bool hand = reach < kForearmMaxMm + 80.0F && other.area_m2 < kForearmAreaMaxM2 && off_floor &&
                      other.height_max_mm - other.height_min_mm > kForearmThickMinMm;
    if (candidate_[b] != 0 && hand) candidate_[b] = 2;
  }
}

// An island is no larger than a hand or forearm, before the body, off the floor, and a short way in space from what
// is already the person. Islands inside the outline belong as well.
void FragmentJoiner::run(const Grid& grid, const BlobFinder& found, bool floor_known, int person,
                         std::span<std::uint8_t> chosen) {
  const auto labels = found.labels();
  const auto list = found.blobs();
  const auto label = static_cast<std::uint16_t>(person + 1);
  const Blob& body = list[at(person)];
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = labels[i] == label ? 1 : 0;
  list_candidates(grid, list, floor_known, person);
  for (int pass = 0; pass < 2; ++pass) {  // a hand may hang on a wrist that is an island itself
    std::fill(touch_.begin(), touch_.end(), 0);
    std::fill(border_.begin(), border_.end(), 0);
    std::fill(gap_mm_.begin(), gap_mm_.end(), 1e9F);
    for (int r = 1; r + 1 < grid.height; ++r) {
      for (int c = 1; c + 1 < grid.width; ++c) {
        const int cell = grid.index(c, r);
        if (labels[at(cell)] == 0 || chosen[at(cell)] != 0 || candidate_[at(labels[at(cell)] - 1)] == 0) continue;
        look_around(grid, labels, chosen, c, r);
      }
    }
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (labels[i] == 0 || chosen[i] != 0) continue;
      const auto b = static_cast<std::size_t>(labels[i] - 1);
      if (candidate_[b] == 0) continue;
      const bool enclosed = list[b].centroid_mm.z < body.centroid_mm.z + 130.0F &&
                            static_cast<float>(touch_[b]) >= 0.55F * static_cast<float>(border_[b]) && touch_[b] > 0;
      if (enclosed || (candidate_[b] == 2 && gap_mm_[b] < gap_max_mm_[b])) chosen[i] = 1;
    }
  }
}

// How much of a candidate's border faces the person, and how near in space it comes.
void FragmentJoiner::look_around(const Grid& grid, std::span<const std::uint16_t> labels,
                                 std::span<const std::uint8_t> chosen, int c, int r) {
  const int cell = grid.index(c, r);
  const std::uint16_t own = labels[at(cell)];
  const auto b = at(own - 1);
  bool edge = false;
  for (const int step : {-1, 1, -grid.width, grid.width}) {
    int other = cell + step;
    if (labels[at(other)] == own) continue;
    edge = true;
    const int next = other + step;
    if (grid.depth[at(other)] == 0 && next >= 0 && next < static_cast<int>(labels.size())) other = next;
    ++border_[b];
    if (chosen[at(other)] != 0) ++touch_[b];
  }
  if (!edge || candidate_[b] != 2) return;
  const Vec3f here = grid.point(cell);
  for (int rr = std::max(0, r - kGapReachCells); rr <= std::min(grid.height - 1, r + kGapReachCells); ++rr) {
    for (int cc = std::max(0, c - kGapReachCells); cc <= std::min(grid.width - 1, c + kGapReachCells); ++cc) {
      const int other = grid.index(cc, rr);
      if (chosen[at(other)] != 0) gap_mm_[b] = std::min(gap_mm_[b], norm(grid.point(other) - here));
    }
  }
}

}  // namespace im2fit::segment
