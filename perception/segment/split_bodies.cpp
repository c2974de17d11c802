// SPDX-License-Identifier: Apache-2.0
// Bodies split in two components: a hand, a hem, a belly bent over hides where the trunk joins the legs, or the head
// the trunk, and neither part has a person's size alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "perception/segment/blobs.h"
#include "perception/segment/split_bodies_limits.h"

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
