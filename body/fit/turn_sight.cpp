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

}  // namespace im2fit::body
