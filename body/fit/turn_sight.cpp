// SPDX-License-Identifier: Apache-2.0
#include "body/fit/turn_sight.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace im2fit::body {
namespace {

constexpr float kNearMm = 200;
constexpr float kMixedFocalPx = 575.8F;  // a Kinect's, whose depth is mixed up to
constexpr float kMixedPx = 4;            // so far from an edge
constexpr float kSameSurfaceMm = 70;
constexpr float kSamePatchMm = 30;
constexpr int kWindowPx = 1;  // each way
constexpr std::size_t kWindowMin = 5;
constexpr float kSameLimbMm = 120;
constexpr int kBeyondPx = 3;
constexpr float kReachMaxPx = 200;
constexpr float kFocalMax = 10, kCentreMax = 2;  // of the picture's longer side
constexpr float kUnitMaxMm = 10;

constexpr float kBendMin = 1.0F / 300, kBendMax = 1.0F / 25;  // of limbs and trunks, 1/mm

constexpr float kCellPx = 4;  // of hiding, at kCellFocalPx
constexpr float kCellFocalPx = 575.8F;
constexpr float kHiddenMm = 40, kHiddenSlopeMm = 30;
constexpr float kHiddenByOtherMm = 12, kOtherPartMm = 130;
constexpr int kHandSteps = 4, kHandCells = 3;
constexpr float kHandReach = 1.4F, kHandThickMm = 25;
constexpr std::uint32_t kNoPoint = 0xFFFFFFFF;
constexpr int kCellsMax = 400;  // a side

}  // namespace

bool usable(const TurnPicture& picture) {
  const Intrinsics& k = picture.intrinsics;
  const auto fits = [&](const auto& image) {
    return image.pixels != nullptr && image.width == k.width && image.height == k.height;
  };
  const auto side = static_cast<float>(std::max(k.width, k.height));
  // Each comparison is false for not-a-number.
  return k.width > 0 && k.height > 0 && k.fx > 0 && k.fy > 0 && k.fx <= kFocalMax * side &&
         k.fy <= kFocalMax * side && std::fabs(k.cx) <= kCentreMax * side && std::fabs(k.cy) <= kCentreMax * side &&
         picture.depth_unit_mm > 0 && picture.depth_unit_mm <= kUnitMaxMm && fits(picture.depth) &&
         fits(picture.mask);
}

TurnSight::TurnSight(const TurnPicture& picture)
    : picture_(picture),
      k_(picture.intrinsics),
      margin_px_(std::max(1, static_cast<int>(kMixedPx * k_.fx / kMixedFocalPx + 0.5F))) {}

bool TurnSight::project(Vec3f p, float& u, float& v) const {
  if (!(p.z > kNearMm)) return false;
  u = k_.fx * p.x / p.z + k_.cx;
  v = k_.fy * p.y / p.z + k_.cy;
  return u >= 0 && v >= 0 && u < static_cast<float>(k_.width) && v < static_cast<float>(k_.height);
}

// Pixels of the person without depth are holes and no edge.
bool TurnSight::clear_of_edges(int u, int v, float depth) const {
  const int m = margin_px_;
  for (int dv = -m; dv <= m; ++dv)
    for (int du = -m; du <= m; ++du) {
      if (du * du + dv * dv > m * m + 1) continue;
      if (picture_.mask.at(u + du, v + dv) == 0) return false;
      const float z = depth_mm(u + du, v + dv);
      if (z > 0 && std::fabs(z - depth) > kSameSurfaceMm) return false;
    }
  return true;
}

bool TurnSight::surface_over(Vec3f p, Vec3f n, float gate_mm, float& off_mm) const {
  float u = 0, v = 0;
  if (!project(p, u, v)) return false;
  const int iu = static_cast<int>(u + 0.5F), iv = static_cast<int>(v + 0.5F), m = margin_px_;
  if (iu < m || iv < m || iu >= k_.width - m || iv >= k_.height - m) return false;
  const float depth = depth_mm(iu, iv);
  if (!(depth > 0) || !clear_of_edges(iu, iv, depth)) return false;
  std::array<float, static_cast<std::size_t>((2 * kWindowPx + 1) * (2 * kWindowPx + 1))> off;
  std::size_t count = 0;
  for (int dv = -kWindowPx; dv <= kWindowPx; ++dv)
    for (int du = -kWindowPx; du <= kWindowPx; ++du) {
      const float z = depth_mm(iu + du, iv + dv);
      if (!(z > 0)) continue;
      off[count++] = dot(n, unproject(k_, static_cast<float>(iu + du), static_cast<float>(iv + dv), z) - p);
    }
  if (count < kWindowMin) return false;
  std::sort(off.begin(), off.begin() + static_cast<std::ptrdiff_t>(count));
  const float median = off[count / 2];
  float sum = 0;
  int used = 0;
  for (std::size_t i = 0; i < count; ++i)
    if (std::fabs(off[i] - median) < kSamePatchMm) {
      sum += off[i];
      ++used;
    }
  off_mm = sum / static_cast<float>(used);
  return std::fabs(off_mm) < gate_mm;
}

bool TurnSight::outline_beside(Vec3f p, Vec3f n, float reach_mm, float& off_mm, Vec3f& direction) const {
  float u = 0, v = 0;
  if (!project(p, u, v)) return false;
  const float x = n.x - n.z * p.x / p.z, y = n.y - n.z * p.y / p.z;
  const float length = std::sqrt(x * x + y * y);
  if (!(length > 0.1F)) return false;
  direction = {x / length, y / length, 0};
  enum class Pixel { outside, other, person };
  float depth = 0;  // of the person's pixel looked at last
  const auto pixel_at = [&](int t) {
    const float a = u + direction.x * static_cast<float>(t) + 0.5F,
                b = v + direction.y * static_cast<float>(t) + 0.5F;
    if (!(a >= 0 && b >= 0 && a < static_cast<float>(k_.width) && b < static_cast<float>(k_.height)))
      return Pixel::outside;
    const int iu = static_cast<int>(a), iv = static_cast<int>(b);
    if (picture_.mask.at(iu, iv) == 0) return Pixel::other;
    depth = depth_mm(iu, iv);
    return Pixel::person;
  };
  const int reach = static_cast<int>(std::fmin(kReachMaxPx, reach_mm * k_.fx / p.z));
  const auto ends_at = [&](int t) {
    if (pixel_at(t) != Pixel::person || !(depth > 0) || std::fabs(depth - p.z) > kSameLimbMm) return false;
    for (int i = 1; i <= kBeyondPx; ++i)
      if (pixel_at(t + i) != Pixel::other) return false;
    return true;
  };
  // The nearest end, outwards first.
  for (int i = 0; i < reach; ++i)
    for (const int t : {i, -1 - i})
      if (ends_at(t)) {
        off_mm = (static_cast<float>(t) + 0.5F) * p.z / k_.fx;
        return true;
      }
  return false;
}

TurnPoints::TurnPoints(const ShapeSpace& space, const RestShape& rest, const SkinGraph& graph)
    : space_(space),
      graph_(graph),
      posed_(space, rest),
      points_(space.point_count),
      in_camera_(space.point_count),
      facing_(space.point_count),
      nearest_(static_cast<std::size_t>(kCellsMax) * kCellsMax) {}

Vec3f TurnPoints::rest_middle(std::size_t i) const {
  const float* at = space_.point_mean.data() + i * kPointValues;
  return {at[0], at[1], at[2]};
}

// Where the points lie in a view, and which of its cells they fill.
void TurnPoints::see(const Pose& pose, const Intrinsics& intrinsics, const PersonAxes& axes) {
  posed_.set(pose);
  seen_k_ = intrinsics;
  camera_ = axes.camera();
  const Intrinsics& k = seen_k_;
  cell_px_ = std::max({1.0F, kCellPx * k.fx / kCellFocalPx, static_cast<float>(k.width) / (kCellsMax - 1),
                       static_cast<float>(k.height) / (kCellsMax - 1)});
  cells_x_ = static_cast<int>(static_cast<float>(k.width) / cell_px_) + 1;
  cells_y_ = static_cast<int>(static_cast<float>(k.height) / cell_px_) + 1;
  std::fill_n(nearest_.begin(), cells_x_ * cells_y_, Near{});
  for (std::uint32_t i = 0; i < space_.point_count; ++i) {
    posed_.find(i, points_[i]);
    const Vec3f p = points_[i].position;
    facing_[i] = dot(points_[i].normal, normalized(camera_ - p));
    in_camera_[i] = axes.to_camera(p);
    if (facing_[i] > 0) fill_cells(in_camera_[i], 1, i);
  }
  // Hands have no points, but hide what is behind them.
  for (const Segment hand : {Segment::left_hand, Segment::right_hand})
    for (int i = 0; i <= kHandSteps; ++i) {
      const Vec3f p = posed_.head(hand) +
                      (posed_.tail(hand) - posed_.head(hand)) * (kHandReach * static_cast<float>(i) / kHandSteps);
      Vec3f c = axes.to_camera(p);
      c.z -= kHandThickMm;
      fill_cells(c, kHandCells, kNoPoint);
    }
}

// The cells about c, `cells` to each side.
void TurnPoints::fill_cells(Vec3f c, int cells, std::uint32_t point) {
  const Intrinsics& k = seen_k_;
  if (!(c.z > 1)) return;
  const float u = (k.fx * c.x / c.z + k.cx) / cell_px_, v = (k.fy * c.y / c.z + k.cy) / cell_px_;
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(cells_x_) && v < static_cast<float>(cells_y_))) return;
  const int cu = static_cast<int>(u), cv = static_cast<int>(v);
  for (int b = std::max(0, cv - cells); b <= std::min(cells_y_ - 1, cv + cells); ++b)
    for (int a = std::max(0, cu - cells); a <= std::min(cells_x_ - 1, cu + cells); ++a) {
      Near& near = nearest_[static_cast<std::size_t>(b * cells_x_ + a)];
      if (near.depth == 0 || c.z < near.depth) near = {c.z, point};
    }
}

// Behind another part of the body. A cell holds what lies within 25 mm, so a slanted skin hides itself a little; a
// limb before a trunk is told from that by its distance on the mean body.
bool TurnPoints::hidden(std::size_t i) const {
  const Intrinsics& k = seen_k_;
  const Vec3f c = in_camera_[i];
  const float u = (k.fx * c.x / c.z + k.cx) / cell_px_, v = (k.fy * c.y / c.z + k.cy) / cell_px_;
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(cells_x_) && v < static_cast<float>(cells_y_))) return true;
  const Near near = nearest_[static_cast<std::size_t>(static_cast<int>(v) * cells_x_ + static_cast<int>(u))];
  if (near.depth == 0 || c.z <= near.depth + kHiddenByOtherMm) return false;
  if (near.point == kNoPoint || norm(rest_middle(i) - rest_middle(near.point)) > kOtherPartMm) return true;
  const float f = std::max(0.3F, std::fabs(facing_[i]));
  const float slope = std::sqrt(std::max(0.0F, 1 - f * f)) / f;
  return c.z > near.depth + kHiddenMm + kHiddenSlopeMm * slope;
}

// How far beyond a point near the outline the outline of a round body lies: with radius r and cosine c between normal
// and view, r (1 - sqrt(1 - c^2)). r from the point's neighbours in the direction of the view.
float TurnPoints::beyond_mm(std::size_t i) const {
  const Vec3f n = points_[i].normal, p = points_[i].position;
  const Vec3f view = normalized(camera_ - p);
  const Vec3f across = normalized(view - n * facing_[i]);
  float bend = 0, weight = 0;
  for (std::size_t k = 0; k < kSkinNeighbours; ++k) {
    const SkinNeighbour& neighbour = graph_.neighbours[i * kSkinNeighbours + k];
    if (!(neighbour.distance_mm > 0)) break;
    const Vec3f d = points_[neighbour.point].position - p;
    const float square = dot(d, d), along = dot(d, across);
    const float w = along * along / square;
    bend += w * -2 * dot(d, n) / square;
    weight += w;
  }
  const float per_mm = std::clamp(bend / std::max(weight, 1e-6F), kBendMin, kBendMax);
  return (1 - std::sqrt(1 - facing_[i] * facing_[i])) / per_mm;
}

}  // namespace im2fit::body
