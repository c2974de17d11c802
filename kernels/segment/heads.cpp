// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kernels/segment/blobs.h"

namespace im2fit::segment {
namespace {

constexpr float kHeadHeightMinMm = 1100.0F;  // above the floor: a seated adult's
constexpr float kHeadHeightMaxMm = 2400.0F;
constexpr float kHeadReliefMinMm = 33.0F;  // heads recede by 50 to 65 mm to their outline, cupboard corners by 20
constexpr float kVagueMm = 4500.0F;
constexpr float kNeckEndMm = 280.0F;  // below the crown
constexpr float kNeckWidthMinMm = 90.0F;
constexpr float kDoubtMax = 1.0F;
constexpr float kDoubtOnLegsMax = 3.0F;
constexpr float kTrunkBeginMm = 270.0F;
constexpr float kTrunkEndMm = 650.0F;  // below the crown
constexpr float kTrunkHalfMm = 180.0F;
constexpr float kHeadApartMm = 320.0F;  // two heads side by side

float cell_mm(const Grid& grid, float z) {
  return static_cast<float>(grid.step) * z / grid.intrinsics.fx;
}

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

// A head: 85..330 mm wide over a hand's breadth below its top, rounded, with shoulders wider than it under it.
// A raised hand fails at the wrist, a box at its missing shoulders, a hat over a coat at the stand's thin
// pole or the coat's flat front.
bool BlobFinder::head_at(const Grid& grid, int blob, int c, int r, Head& out) const {
  const auto label = static_cast<std::uint16_t>(blob + 1);
  if (r < 1 || r + 3 >= grid.height) return false;
  int probe = grid.index(c, r + 2);
  if (labels_[at(probe)] != label) probe = grid.index(c, r);
  if (labels_[at(probe)] != label) return false;
  const float z_head = static_cast<float>(grid.depth[at(probe)]);
  const float mm = cell_mm(grid, z_head);
  float narrowest = 1e9F;
  float widest = 0;
  float width_sum = 0;
  float relief_sum = 0;
  int row_count = 0;
  int at_border = 0;
  float neck = 1e9F;
  float shoulders = 0;
  float left_reach = 0;
  float right_reach = 0;
  float bulge_square_sum = 0;
  int bulge_count = 0;
  int head_lo = c;
  int head_hi = c;
  int centre = c;
  for (int row = r; row < grid.height; ++row) {
    const float below = static_cast<float>(row - r) * mm;
    if (below > kTrunkEndMm) break;
    const auto inside = [&](int col) {
      const int cell = grid.index(col, row);
      return labels_[at(cell)] == label && std::fabs(static_cast<float>(grid.depth[at(cell)]) - z_head) < 280.0F;
    };
    int start = centre;
    for (int away = 1; away <= 3 && !inside(start); ++away) {
      if (centre - away >= 0 && inside(centre - away))
        start = centre - away;
      else if (centre + away < grid.width && inside(centre + away))
        start = centre + away;
    }
    if (!inside(start)) {
      if (below < kNeckEndMm && below > 20.0F) return false;
      continue;
    }
    int lo = start;
    int hi = start;
    while (lo > 0 && (inside(lo - 1) || (lo > 1 && inside(lo - 2)))) --lo;
    while (hi + 1 < grid.width && (inside(hi + 1) || (hi + 2 < grid.width && inside(hi + 2)))) ++hi;
    const float width = static_cast<float>(hi - lo + 1) * mm;
    if (below <= 170.0F) centre = (lo + hi) / 2;
    if (below >= 55.0F && below <= 165.0F) {
      narrowest = std::min(narrowest, width);
      widest = std::max(widest, width);
      width_sum += width;
      const auto z_at = [&](int col) { return static_cast<float>(grid.depth[at(grid.index(col, row))]); };
      if (inside(lo) && inside(hi) && inside(centre)) relief_sum += 0.5F * (z_at(lo) + z_at(hi)) - z_at(centre);
      head_lo = lo;
      head_hi = hi;
      at_border += lo == 0 || hi == grid.width - 1 ? 1 : 0;
      ++row_count;
    }
    if (below >= 165.0F && below < kNeckEndMm) {
      if (width < kNeckWidthMinMm - mm) return false;
      neck = std::min(neck, width);
    }
    if (below >= 270.0F) {
      const int half = std::max(1, static_cast<int>(kTrunkHalfMm / mm));
      const int left = std::max(lo + 1, centre - half);
      const int right = std::min(hi - 1, centre + half);
      if (left < centre && centre < right && inside(left) && inside(right) && inside(centre)) {
        const auto z_at = [&](int col) { return static_cast<float>(grid.depth[at(grid.index(col, row))]); };
        const float share = static_cast<float>(centre - left) / static_cast<float>(right - left);
        const float bulge = z_at(left) + share * (z_at(right) - z_at(left)) - z_at(centre);
        bulge_square_sum += bulge * bulge;
        ++bulge_count;
      }
    }
    if (below >= 270.0F && below <= 430.0F) {
      shoulders = std::max(shoulders, width);
      left_reach = std::max(left_reach, static_cast<float>(head_lo - lo) * mm);
      right_reach = std::max(right_reach, static_cast<float>(hi - head_hi) * mm);
    }
  }
  if (row_count == 0) return false;
  const float width = width_sum / static_cast<float>(row_count);
  if (at_border * 2 > row_count || narrowest < 0.45F * widest) return false;  // cut in two; a cupboard's corner
  if (neck > 1.25F * width + mm) return false;  // widens steadily, as a cupboard's top seen over its corner
  if (narrowest < 85.0F - mm || widest > 330.0F + mm || width < 105.0F || width > 270.0F + 0.5F * mm) return false;
  if (shoulders < std::max(220.0F, 1.2F * width)) return false;
  if (std::max(left_reach, right_reach) < 40.0F || std::min(left_reach, right_reach) < -0.25F * width) return false;
  const float round = kHeadReliefMinMm - 0.2F * quantum_mm(z_head);
  if (relief_sum < round * static_cast<float>(row_count)) return false;
  // Some backs are as flat as a coat.
  const float bulge = bulge_count > 0 ? std::sqrt(bulge_square_sum / static_cast<float>(bulge_count)) : 1e9F;
  if (bulge < 10.0F + 0.35F * quantum_mm(z_head)) return false;
  // Each limit keeps 95 % of 250 dressed people's heads in furnished rooms; hats on chairs and stands miss several.
  const int trunk_first = r + static_cast<int>(kTrunkBeginMm / mm);
  const int trunk_last = r + static_cast<int>(kTrunkEndMm / mm);
  const float doubt = trunk_doubt(trunk_shape(grid, blob, centre, trunk_first, trunk_last, z_head)) +
                      std::max(0.0F, (width - 192.0F) / 25.0F) + std::max(0.0F, (neck - 150.0F) / 25.0F) +
                      std::max(0.0F, (2.2F - shoulders / width) / 0.25F);
  if (doubt > kDoubtMax && (doubt > kDoubtOnLegsMax || !has_legs(grid, blob))) return false;
  out.vague = bulge < 14.0F + 0.5F * quantum_mm(z_head) || z_head > kVagueMm;
  out.blob = blob;
  out.c = centre;
  out.r = r;
  out.top_mm = grid.point(probe);
  out.width_mm = width;
  return true;
}

void BlobFinder::find_heads(const Grid& grid, int b, const FloorPlane& floor) {
  const Blob& blob = blobs_[at(b)];
  const auto label = static_cast<std::uint16_t>(b + 1);
  std::fill(top_.begin(), top_.end(), static_cast<std::int16_t>(grid.height));
  for (int c = blob.c_min; c <= blob.c_max; ++c)
    for (int r = blob.r_min; r <= blob.r_max; ++r)
      if (labels_[at(grid.index(c, r))] == label) {
        top_[at(c)] = static_cast<std::int16_t>(r);
        break;
      }
  for (int c = blob.c_min; c <= blob.c_max; ++c) {
    const int r = top_[at(c)];
    if (r >= grid.height) continue;
    const float z = static_cast<float>(grid.depth[at(grid.index(c, r))]);
    const int reach = std::max(1, static_cast<int>(90.0F / cell_mm(grid, z)));
    bool peak = true;
    for (int d = -reach; d <= reach && peak; ++d) {
      const int other = c + d;
      if (d == 0 || other < blob.c_min || other > blob.c_max) continue;
      if (top_[at(other)] < r || (top_[at(other)] == r && d < 0)) peak = false;  // leftmost of a flat top
    }
    if (!peak) continue;
    int flat = c;  // middle of a flat top
    while (flat + 1 <= blob.c_max && top_[at(flat + 1)] == r && flat - c < reach) ++flat;
    Head head;
    if (!head_at(grid, b, (c + flat) / 2, r, head)) continue;
    if (floor.known) {
      const float height = grid.height_mm[at(grid.index((c + flat) / 2, r))];
      if (height < kHeadHeightMinMm || height > kHeadHeightMaxMm) continue;
    }
    bool apart = true;
    for (int h = 0; h < head_count_; ++h) {
      const Vec3f d = heads_[at(h)].top_mm - head.top_mm;
      if (heads_[at(h)].blob == b && d.x * d.x + d.z * d.z < kHeadApartMm * kHeadApartMm) apart = false;
    }
    if (apart && head_count_ < kHeadCountMax) heads_[at(head_count_++)] = head;
  }
}

}  // namespace im2fit::segment
