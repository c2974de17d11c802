// SPDX-License-Identifier: Apache-2.0
// People who touch are one surface: it is divided between their heads, seen or expected.
#include <algorithm>
#include <cmath>

#include "perception/segment/blobs.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [touch] people who touch with their heads out of the picture (commit 3dafe52, tried on 250 furnished,
//           dressed scenes); no measurement of these on record
namespace im2fit::segment::split_limits {

constexpr float kSeenNearMm = 400.0F;    // from an expected head to one seen: they are the same; [touch]
constexpr float kUnderMm = 160.0F;       // either side of the line below a crown: half a trunk's width; [touch]
constexpr float kUnderAreaMinM2 = 0.1F;  // surface there, least; [touch]
constexpr float kDepthWeight = 0.7F;     // distance in depth, in units of that sideways; [touch]

}  // namespace im2fit::segment::split_limits

namespace im2fit::segment {

using namespace split_limits;

namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// Along the floor.
float apart_mm(Vec3f a, Vec3f b, Vec3f up) {
  const Vec3f d = a - b;
  return norm(d - up * dot(up, d));
}

}  // namespace

// The blob with the most surface about the line down from `crown`, as much as a trunk's; -1: none.
int BlobFinder::blob_under(const Grid& grid, Vec3f crown, Vec3f up) const {
  std::array<float, kBlobCountMax> area_m2{};
  const float cell_area =
      static_cast<float>(grid.step * grid.step) / (grid.intrinsics.fx * grid.intrinsics.fy) * 1e-6F;
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const int label = labels_[at(grid.index(c, r))];
      if (label == 0) continue;
      const Vec3f p = grid.point(c, r);
      if (apart_mm(p, crown, up) < kUnderMm) area_m2[at(label - 1)] += cell_area * p.z * p.z;
    }
  }
  const auto most = std::max_element(area_m2.begin(), area_m2.begin() + blob_count_);
  return most != area_m2.begin() + blob_count_ && *most >= kUnderAreaMinM2 ? static_cast<int>(most - area_m2.begin())
                                                                           : -1;
}

// Adds the heads expected, unless they are seen or alone in their blob.
void BlobFinder::expect_heads(const Grid& grid, const FloorPlane& floor, std::span<const Vec3f> expected) {
  const Vec3f up = floor.up;
  const int seen_count = head_count_;
  for (const Vec3f& crown : expected) {
    bool seen = head_count_ == kHeadCountMax;
    for (int h = 0; h < seen_count; ++h) seen = seen || apart_mm(heads_[at(h)].top_mm, crown, up) < kSeenNearMm;
    if (seen) continue;
    Head head;
    head.blob = blob_under(grid, crown, up);
    head.top_mm = crown;
    head.seen = false;
    if (head.blob >= 0) heads_[at(head_count_++)] = head;
  }
}

// Each cell goes with the head it is nearest to.
void BlobFinder::split_between_heads(const Grid& grid) {
  bool split = false;
  const int before = blob_count_;
  for (int b = 0; b < before; ++b) {
    int first = -1;
    std::array<int, kHeadCountMax> mine{};
    int count = 0;
    for (int h = 0; h < head_count_; ++h)
      if (heads_[at(h)].blob == b) mine[at(count++)] = h;
    if (count < 2) continue;
    first = mine[0];
    for (int i = 1; i < count; ++i) {
      if (blob_count_ == kBlobCountMax) return;
      heads_[at(mine[at(i)])].blob = blob_count_++;
      split = true;
    }
    const auto old_label = static_cast<std::uint16_t>(b + 1);
    for (int cell = 0; cell < static_cast<int>(labels_.size()); ++cell) {
      if (labels_[at(cell)] != old_label) continue;
      const Vec3f p = grid.point(cell);
      float best = 1e30F;
      int owner = first;
      for (int i = 0; i < count; ++i) {
        const Vec3f d = p - heads_[at(mine[at(i)])].top_mm;
        const float cost = std::fabs(d.x) + kDepthWeight * std::fabs(d.z);
        if (cost < best) {
          best = cost;
          owner = mine[at(i)];
        }
      }
      labels_[at(cell)] = static_cast<std::uint16_t>(heads_[at(owner)].blob + 1);
    }
  }
  if (split) describe(grid);
}

}  // namespace im2fit::segment
