// SPDX-License-Identifier: Apache-2.0
// Bodies split in two components: a hand, a hem, a belly bent over hides where the trunk joins the legs, or the head
// the trunk, and neither part has a person's size alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "perception/segment/blobs.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [joined]  came with the joining of split bodies, seed 8101: NO_PERSON instead of NOT_FRONTAL in 7 of 100
//             before, 3 after; of NOT_UPRIGHT 8 and 2; all changes together (commit a94b161)
//   [bent]    came with trunks bent far forwards, 240 full scenes of seed 8101: IoU p5 0.927 before, 0.944
//             after, all changes together (commit deeed50)
//   [astride] came with legs astride under a trunk (commit 58bc2de); no measurement of it on record
namespace im2fit::segment::split_bodies_limits {

constexpr float kLowMaxMm = 250.0F;         // lower component, above the floor: it stands; [joined]
constexpr float kLowerTallMinMm = 500.0F;   // its height, least; [joined]
constexpr float kTopMinMm = 1100.0F;        // top of both above the floor, least; [joined]
constexpr float kTopMaxMm = 2200.0F;        // and most; [joined]
constexpr float kOverMm = 200.0F;           // what the upper component reaches above the lower, least; [joined]
constexpr float kPartAreaMinM2 = 0.03F;     // of either, least: a head's; [joined]
constexpr float kPartAreaMaxM2 = 0.6F;      // and most; [joined]
constexpr float kLowerWideMaxMm = 700.0F;   // width of the lower, most; [bent]
constexpr float kAstrideMaxMm = 1000.0F;    // the same of what has the shape of legs; [astride]
constexpr float kUpperWideMaxMm = 1300.0F;  // width of the upper, most: arms held out; [bent]
constexpr float kAsideMm = 280.0F;          // between the middles sideways, most; [joined]
constexpr float kBehindMm = 550.0F;         // between the middles in depth, most: a trunk bent forwards; [bent]
constexpr float kBehindHeadMm = 250.0F;  // the same where a head is seen: another person's legs may be behind; [bent]
constexpr int kStepMaxMm = 600;          // in depth where they meet, most: a hand before the hip; [joined]
constexpr int kMeetRows = 4;             // between them, most: noise; [joined]
constexpr int kMeetCellsMin = 4;         // where they meet, least; [joined]
constexpr float kRoundMin = 11.0F;       // roundness of both, least; [joined]

}  // namespace im2fit::segment::split_bodies_limits

namespace im2fit::segment {

using namespace split_bodies_limits;

namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

// What begins under something, over two fifths of its upper part's width and more, at about its depth: -1 where there
// is no such thing. Feet astride reach beyond what is above them.
int BlobFinder::blob_over(const Grid& grid, int b) const {
  const Blob& blob = blobs_[at(b)];
  const auto label = static_cast<std::uint16_t>(b + 1);
  const int r_middle = (blob.r_min + blob.r_max) / 2;
  std::array<std::int16_t, kBlobCountMax> met{};
  int columns = 0;
  for (int c = blob.c_min; c <= blob.c_max; ++c) {
    int r = blob.r_min;
    while (r <= r_middle && labels_[at(grid.index(c, r))] != label) ++r;
    if (r > r_middle) continue;
    ++columns;
    const int z = grid.depth[at(grid.index(c, r))];
    for (int d = 1; d <= kMeetRows && r - d >= 0; ++d) {
      const auto above = at(grid.index(c, r - d));
      if (labels_[above] == 0) continue;
      if (std::abs(grid.depth[above] - z) < kStepMaxMm) ++met[at(labels_[above] - 1)];
      break;
    }
  }
  const auto most = std::max_element(met.begin(), met.begin() + blob_count_);
  const bool meets = *most >= kMeetCellsMin && *most * 5 > columns * 2;
  return meets ? static_cast<int>(most - met.begin()) : -1;
}

// Both as round as parts of bodies are, one over the other.
void BlobFinder::join_split_bodies(const Grid& grid, const FloorPlane& floor) {
  if (!floor.known) return;
  const auto mm = [&](const Blob& blob) {
    return static_cast<float>(grid.step) * blob.centroid_mm.z / grid.intrinsics.fx;
  };
  const auto part = [&](const Blob& blob, float wide_max_mm) {
    return blob.area_m2 > kPartAreaMinM2 && blob.area_m2 < kPartAreaMaxM2 &&
           static_cast<float>(blob.c_max - blob.c_min + 1) * mm(blob) < wide_max_mm;
  };
  const auto heads_of = [&](int b, bool seen) {
    return std::count_if(heads_.begin(), heads_.begin() + head_count_,
                         [=](const Head& h) { return h.blob == b && h.seen == seen; });
  };
  bool joined = false;
  for (int b = 0; b < blob_count_; ++b) {
    const Blob& lower = blobs_[at(b)];
    const bool stands = lower.height_min_mm < kLowMaxMm && lower.height_max_mm < kTopMaxMm - kOverMm &&
                        lower.height_max_mm - lower.height_min_mm > kLowerTallMinMm;
    if (!stands || !part(lower, has_legs(grid, b) ? kAstrideMaxMm : kLowerWideMaxMm) || heads_of(b, true) > 0)
      continue;
    const int o = blob_over(grid, b);
    if (o < 0 || heads_of(o, true) > 1 || heads_of(b, false) + heads_of(o, false) > 1) continue;
    const Blob& upper = blobs_[at(o)];
    const Vec3f off = upper.centroid_mm - lower.centroid_mm;
    const bool fits = part(upper, kUpperWideMaxMm) &&
                      upper.height_max_mm > std::max(kTopMinMm, lower.height_max_mm + kOverMm) &&
                      upper.height_max_mm < kTopMaxMm && std::fabs(off.x) < kAsideMm &&
                      std::fabs(off.z) < (heads_of(o, true) > 0 ? kBehindHeadMm : kBehindMm);
    if (!fits) continue;
    if (roundness(grid, b, lower.r_max).score < kRoundMin || roundness(grid, o, upper.r_max).score < kRoundMin)
      continue;
    for (std::uint16_t& cell : labels_)
      if (cell == static_cast<std::uint16_t>(b + 1)) cell = static_cast<std::uint16_t>(o + 1);
    joined = true;
  }
  if (joined) describe(grid);
}

}  // namespace im2fit::segment
