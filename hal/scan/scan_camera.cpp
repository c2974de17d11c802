// SPDX-License-Identifier: Apache-2.0
#include "hal/scan/scan_camera.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace im2fit::hal {
namespace {

constexpr int kWidth = 480, kHeight = 640;
constexpr float kFocalPx = 575.8F;                 // of a Kinect: what the tracker knows
constexpr float kAwayMm = 2400, kCameraMm = 1000;  // from the person's axis, and above the floor
constexpr float kFloorReachMm = 1200;              // about the person
constexpr float kDegree = 3.14159265F / 180;
constexpr float kApartMm = 40;      // in depth: another surface
constexpr double kSkinMm2 = 1.9e6;  // of an adult: how far a cloud's points lie from one another
constexpr int kReachMaxPx = 6;

std::size_t place(int u, int v) {
  return static_cast<std::size_t>(v) * kWidth + static_cast<std::size_t>(u);
}

float edge(Vec3f a, Vec3f b, float u, float v) {
  return (b.x - a.x) * (v - a.y) - (b.y - a.y) * (u - a.x);
}

}  // namespace

Intrinsics ScanCamera::intrinsics() {
  return {kWidth, kHeight, kFocalPx, kFocalPx, (kWidth - 1) * 0.5F, (kHeight - 1) * 0.5F};
}

ScanCamera::ScanCamera(StandingScan scan)
    : scan_(std::move(scan)),
      seen_(scan_.points.size()),
      nearest_(static_cast<std::size_t>(kWidth) * kHeight),
      kept_(nearest_.size()),
      back_(nearest_.size()) {
  if (scan_.triangles.empty()) {
    const double apart_mm = std::sqrt(kSkinMm2 / static_cast<double>(scan_.points.size()));
    // Twice the mean distance closes nearly all gaps of points that lie at random.
    const double px = apart_mm * static_cast<double>(kFocalPx / kAwayMm);

    reach_px_ = std::clamp(static_cast<int>(std::ceil(2 * px)), 1, kReachMaxPx);
    return;
  }
  std::vector<std::uint16_t> picture(nearest_.size());
  render(0, {picture.data(), kWidth, kHeight});
  std::size_t body = 0, inside = 0;
  for (std::size_t i = 0; i < nearest_.size(); ++i) {
    body += nearest_[i] > 0 ? 1 : 0;
    inside += nearest_[i] > 0 && back_[i] != 0 ? 1 : 0;
  }
  two_sided_ = 3 * inside > body;
}

CameraPose ScanCamera::pose(float yaw_deg) {
  const float half = -0.5F * yaw_deg * kDegree, yaw = yaw_deg * kDegree;
  CameraPose out;
  out.y = std::sin(half);
  out.w = std::cos(half);
  out.position_mm = {kAwayMm * std::sin(yaw), 0, kAwayMm * (1 - std::cos(yaw))};
  return out;
}

// Nearest surface at each pixel's centre: 1/z is linear in the picture.
void ScanCamera::draw_triangles() {
  for (const ScanTriangle& t : scan_.triangles) {
    const Vec3f a = seen_[t[0]], b = seen_[t[1]], c = seen_[t[2]];
    const float area = edge(a, b, c.x, c.y);
    if (area == 0) continue;
    // The person is within 1.5 m of the axis: nothing here is larger than some thousand pixels.
    const int u0 = std::max(0, static_cast<int>(std::ceil(std::min({a.x, b.x, c.x}))));
    const int u1 = std::min(kWidth - 1, static_cast<int>(std::floor(std::max({a.x, b.x, c.x}))));
    const int v0 = std::max(0, static_cast<int>(std::ceil(std::min({a.y, b.y, c.y}))));
    const int v1 = std::min(kHeight - 1, static_cast<int>(std::floor(std::max({a.y, b.y, c.y}))));
    const float per_area = 1 / area, near_a = 1 / a.z, near_b = 1 / b.z, near_c = 1 / c.z;
    // v grows downwards: what goes round counter-clockwise seen from outside goes round the other way here.
    const std::uint8_t back = area > 0 ? 1 : 0;
    for (int v = v0; v <= v1; ++v)
      for (int u = u0; u <= u1; ++u) {
        const auto x = static_cast<float>(u), y = static_cast<float>(v);
        const float wa = edge(b, c, x, y) * per_area, wb = edge(c, a, x, y) * per_area, wc = 1 - wa - wb;
        if (wa < 0 || wb < 0 || wc < 0) continue;
        const float z = 1 / (wa * near_a + wb * near_b + wc * near_c);
        const std::size_t i = place(u, v);
        if (nearest_[i] > 0 && nearest_[i] <= z) continue;
        nearest_[i] = z;
        back_[i] = back;
      }
  }
}

// A point a pixel. What lies behind its neighbours is seen through a gap; gaps between points of one surface are
// closed, its outline stays where it is.
void ScanCamera::draw_points() {
  for (const Vec3f p : seen_) {
    const int u = static_cast<int>(std::lround(p.x)), v = static_cast<int>(std::lround(p.y));
    if (u < 0 || u >= kWidth || v < 0 || v >= kHeight) continue;
    float& nearest = nearest_[place(u, v)];
    if (nearest == 0 || p.z < nearest) nearest = p.z;
  }
  const int r = reach_px_;
  kept_ = nearest_;
  for (int v = r; v < kHeight - r; ++v)
    for (int u = r; u < kWidth - r; ++u) {
      const float z = kept_[place(u, v)];
      if (z == 0) continue;
      for (int dv = -r; dv <= r; ++dv)
        for (int du = -r; du <= r; ++du)
          if (const float other = kept_[place(u + du, v + dv)]; other > 0 && other < z - kApartMm)
            nearest_[place(u, v)] = 0;
    }
  kept_ = nearest_;
  const auto first = [&](int u, int v, int du, int dv) {
    for (int i = 1; i <= r; ++i)
      if (const float z = kept_[place(u + i * du, v + i * dv)]; z > 0) return std::pair{z, i};
    return std::pair{0.0F, 0};
  };
  for (int v = r; v < kHeight - r; ++v)
    for (int u = r; u < kWidth - r; ++u) {
      if (kept_[place(u, v)] > 0) continue;
      float sum = 0, weight = 0;
      for (const auto& [du, dv] : {std::pair{1, 0}, std::pair{0, 1}}) {
        const auto [z0, i0] = first(u, v, -du, -dv);
        const auto [z1, i1] = first(u, v, du, dv);
        if (z0 == 0 || z1 == 0 || std::fabs(z0 - z1) > kApartMm) continue;
        const float w = 1 / static_cast<float>(i0 + i1);
        sum += w * (z0 * static_cast<float>(i1) + z1 * static_cast<float>(i0)) / static_cast<float>(i0 + i1);
        weight += w;
      }
      if (weight > 0) nearest_[place(u, v)] = sum / weight;
    }
}

void ScanCamera::render(float yaw_deg, DepthImage out) {
  const float s = std::sin(yaw_deg * kDegree), c = std::cos(yaw_deg * kDegree);
  const Intrinsics k = intrinsics();
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Vec3f p = scan_.points[i];
    const float z = std::max(1.0F, kAwayMm - (s * p.x + c * p.z));
    seen_[i] = {k.fx * (c * p.x - s * p.z) / z + k.cx, k.fy * (kCameraMm - p.y) / z + k.cy, z};
  }
  std::fill(nearest_.begin(), nearest_.end(), 0.0F);
  std::fill(back_.begin(), back_.end(), std::uint8_t{0});
  if (scan_.triangles.empty())
    draw_points();
  else
    draw_triangles();
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const std::size_t i = place(u, v);
      float z = nearest_[i];
      if (z == 0 && static_cast<float>(v) > k.cy) {
        const float floor_z = kCameraMm * k.fy / (static_cast<float>(v) - k.cy);
        const float aside = (static_cast<float>(u) - k.cx) * floor_z / k.fx;
        if (std::hypot(aside, floor_z - kAwayMm) < kFloorReachMm) z = floor_z;
      } else if (!two_sided_ && back_[i] != 0) {
        z = 0;
      }
      out.at(u, v) = static_cast<std::uint16_t>(std::lround(std::min(z, 65535.0F)));
    }
}

}  // namespace im2fit::hal
