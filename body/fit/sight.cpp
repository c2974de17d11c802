// SPDX-License-Identifier: Apache-2.0
#include "body/fit/sight.h"

#include <cmath>

namespace im2fit::body {
namespace {

constexpr float kFarMm = 20000;     // joints and floors beyond this are invalid
constexpr float kNearMm = 200;      // no camera of ours measures nearer
constexpr int kMaskMarginPx = 2;    // pixels at the edge mix the person with the background
constexpr float kSameLimbMm = 120;  // between a point and the surface inside its outline
constexpr float kOutlineStepMax = 1000;
constexpr float kNormalFlatMin = 0.5F;  // of a unit normal's part in the picture's plane

bool bounded(Vec3f v, float limit) {
  return std::fabs(v.x) < limit && std::fabs(v.y) < limit && std::fabs(v.z) < limit;  // false for not-a-number
}

bool same_size(const auto& image, const Intrinsics& k) {
  return image.pixels != nullptr && image.width == k.width && image.height == k.height;
}

}  // namespace

bool Sight::look(const FitView& view) {
  view_ = &view;
  const Intrinsics& k = view.intrinsics;
  if (k.width <= 0 || k.height <= 0 || !(k.fx > 0 && k.fy > 0) || !same_size(view.depth_q4, k) ||
      !same_size(view.mask, k))
    return false;
  for (const Vec3f& p : view.joints.position_mm)
    if (!bounded(p, kFarMm)) return false;
  if (view.floor.known && (!bounded(view.floor.up, 2) || !(norm(view.floor.up) > 0.5F) ||
                           !(std::fabs(view.floor.camera_height_mm) < kFarMm)))
    return false;
  axes_ = PersonAxes(view.joints, view.floor);
  joints_ = axes_.to_mesh(view.joints);
  return true;
}

bool Sight::surface_over(Vec3f p, float gate_mm, Vec3f& seen) const {
  if (!(p.z > kNearMm)) return false;
  const Intrinsics& k = view_->intrinsics;
  const float u = k.fx * p.x / p.z + k.cx + 0.5F, v = k.fy * p.y / p.z + k.cy + 0.5F;
  constexpr int m = kMaskMarginPx;
  if (!(u >= m && v >= m && u < static_cast<float>(k.width - m) && v < static_cast<float>(k.height - m)))
    return false;
  const int iu = static_cast<int>(u), iv = static_cast<int>(v);
  const MaskView& mask = view_->mask;
  if (mask.at(iu, iv) == 0 || mask.at(iu - m, iv) == 0 || mask.at(iu + m, iv) == 0 || mask.at(iu, iv - m) == 0 ||
      mask.at(iu, iv + m) == 0)
    return false;
  const float z = depth_mm(iu, iv);
  if (!(z > 0) || !(std::fabs(z - p.z) < gate_mm)) return false;
  seen = axes_.to_mesh(unproject(k, static_cast<float>(iu), static_cast<float>(iv), z));
  return true;
}

// Walks in half pixels to where the mask changes; the edge is taken in the middle.
bool Sight::outline_beside(Vec3f p, Vec3f normal, float reach_mm, float& distance_mm) const {
  if (!(p.z > kNearMm)) return false;
  const Intrinsics& k = view_->intrinsics;
  const float u = k.fx * p.x / p.z + k.cx, v = k.fy * p.y / p.z + k.cy;
  // A point far outside the picture has no edge within reach, and its place may not fit an int.
  if (!(std::fabs(u) < 2.0F * static_cast<float>(k.width) && std::fabs(v) < 2.0F * static_cast<float>(k.height)))
    return false;
  const float length = std::sqrt(normal.x * normal.x + normal.y * normal.y);
  if (!(length > kNormalFlatMin)) return false;
  const float du = normal.x / length, dv = normal.y / length;
  const float mm_per_px = p.z / k.fx;
  const int steps = static_cast<int>(std::fmin(reach_mm / mm_per_px * 2, kOutlineStepMax)) + 1;
  const auto pixel = [](float at) { return static_cast<int>(at + 0.5F); };
  const bool within = inside(pixel(u), pixel(v));
  for (int i = 1; i <= steps; ++i) {
    const float t = 0.5F * static_cast<float>(within ? i : -i);
    if (inside(pixel(u + du * t), pixel(v + dv * t)) == within) continue;
    const float edge = within ? t - 0.25F : t + 0.25F;
    const int iu = pixel(u + du * (edge - 1)), iv = pixel(v + dv * (edge - 1));
    if (!inside(iu, iv)) return false;
    const float z = depth_mm(iu, iv);
    if (!(z > 0) || std::fabs(z - p.z) > kSameLimbMm) return false;
    distance_mm = edge * mm_per_px;
    return true;
  }
  return false;
}

}  // namespace im2fit::body
