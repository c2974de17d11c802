// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/scene_props.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kPropStream = 0x6D1DC;
constexpr double kNoisePerMm = 1.425e-6;  // spread in mm by depth squared: Khoshelham and Elberink 2012
constexpr float kFar = std::numeric_limits<float>::infinity();

// Depth at which the ray `d` (z 1) from the camera enters a ball; kFar: it does not.
float hit_ball(Vec3f d, Vec3f centre, float radius) {
  const float a = dot(d, d), b = dot(d, centre), c = dot(centre, centre) - radius * radius;
  const float q = b * b - a * c;
  return q < 0 ? kFar : (b - std::sqrt(q)) / a;
}

// The same for a capsule: its two balls and the tube between them.
float hit_capsule(Vec3f d, const PropCapsule& k) {
  float best = std::min(hit_ball(d, k.from, k.radius_mm), hit_ball(d, k.to, k.radius_mm));
  const Vec3f axis = k.to - k.from;
  const float length2 = dot(axis, axis);
  if (length2 < 1) return best;
  const Vec3f across = d - axis * (dot(d, axis) / length2), start = k.from - axis * (dot(k.from, axis) / length2);
  const float a = dot(across, across), b = dot(across, start);
  const float q = b * b - a * (dot(start, start) - k.radius_mm * k.radius_mm);
  if (q < 0 || a < 1e-12F) return best;
  const float t = (b - std::sqrt(q)) / a;
  const float along = dot(d * t - k.from, axis);
  return along >= 0 && along <= length2 ? std::min(best, t) : best;
}

Vec3f ray_of(const Intrinsics& k, int u, int v) {
  return {(static_cast<float>(u) - k.cx) / k.fx, (static_cast<float>(v) - k.cy) / k.fy, 1};
}

// In front of the present depth.
void put(float z_mm, Rng& rng, std::uint16_t& depth) {
  if (!(z_mm > 400) || z_mm >= static_cast<float>(depth)) return;
  const double z = static_cast<double>(z_mm);
  depth = static_cast<std::uint16_t>(std::lround(z + rng.normal(0, kNoisePerMm * z * z)));
}

void draw_animal(const Animal& animal, const PropAxes& axes, const Intrinsics& k, std::uint64_t frame, Rng& rng,
                 DepthImage depth) {
  const Vec3f place = animal.place + animal.step * static_cast<float>(frame);
  std::vector<PropCapsule> parts;
  float u_min = kFar, v_min = kFar, u_max = -kFar, v_max = -kFar;
  for (const PropCapsule& part : animal.parts) {
    parts.push_back({axes.to_camera(place + part.from), axes.to_camera(place + part.to), part.radius_mm});
    for (const Vec3f p : {parts.back().from, parts.back().to}) {
      const float z = p.z - part.radius_mm;
      if (!(z > 100)) return;  // at the camera itself
      const float reach = 2 * part.radius_mm;
      u_min = std::min(u_min, k.fx * (p.x - reach) / z + k.cx);
      u_max = std::max(u_max, k.fx * (p.x + reach) / z + k.cx);
      v_min = std::min(v_min, k.fy * (p.y - reach) / z + k.cy);
      v_max = std::max(v_max, k.fy * (p.y + reach) / z + k.cy);
    }
  }
  const auto clamped = [](float at, int size) {
    return static_cast<int>(std::clamp(at, 0.0F, static_cast<float>(size - 1)));
  };
  for (int v = clamped(v_min, k.height); v <= clamped(v_max, k.height); ++v)
    for (int u = clamped(u_min, k.width); u <= clamped(u_max, k.width); ++u) {
      float nearest = kFar;
      for (const PropCapsule& part : parts) nearest = std::min(nearest, hit_capsule(ray_of(k, u, v), part));
      put(nearest, rng, depth.at(u, v));
    }
}

void draw_mirror(const MirrorWall& wall, const PropAxes& axes, const Intrinsics& k, Rng& rng, DepthImage depth) {
  const Vec3f normal = axes.direction(wall.normal), foot = axes.to_camera(wall.normal * wall.distance_mm);
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) {
      const Vec3f d = ray_of(k, u, v);
      const float z = dot(foot, normal) / dot(d, normal);
      if (!(z > 0)) continue;
      const Vec3f at = axes.from_camera(d * z);
      const float along = at.x * -wall.normal.z + at.z * wall.normal.x;
      if (std::fabs(along) < wall.half_width_mm && at.y > wall.bottom_mm && at.y < wall.top_mm) continue;
      put(z, rng, depth.at(u, v));
    }
}

}  // namespace

Animal make_animal(float height_mm, float heading_deg) {
  // A retriever of 570 mm at the shoulder, along x.
  static const PropCapsule kDog[] = {
      {{-250, 430, 0}, {220, 440, 0}, 120},  {{240, 470, 0}, {390, 620, 0}, 75},
      {{400, 650, 0}, {480, 630, 0}, 80},    {{520, 610, 0}, {580, 595, 0}, 45},
      {{200, 400, 75}, {210, 35, 75}, 38},   {{200, 400, -75}, {190, 35, -75}, 38},
      {{-260, 400, 75}, {-280, 35, 75}, 42}, {{-260, 400, -75}, {-250, 35, -75}, 42},
      {{-360, 500, 0}, {-560, 620, 0}, 25},
  };
  constexpr float kDogHeightMm = 570;
  const float scale = height_mm / kDogHeightMm, angle = heading_deg * std::numbers::pi_v<float> / 180;
  const float c = std::cos(angle), s = std::sin(angle);
  const auto placed = [&](Vec3f p) { return Vec3f{c * p.x + s * p.z, p.y, c * p.z - s * p.x} * scale; };
  Animal animal;
  for (const PropCapsule& part : kDog)
    animal.parts.push_back({placed(part.from), placed(part.to), part.radius_mm * scale});
  return animal;
}

PropAxes::PropAxes(const FloorPlane& floor, float distance_mm)
    : up_(floor.up),
      forward_(normalized(Vec3f{0, 0, 1} - floor.up * floor.up.z)),
      right_(cross(forward_, floor.up)),
      base_(forward_ * distance_mm - floor.up * floor.camera_height_mm) {}

Vec3f PropAxes::from_camera(Vec3f p) const {
  const Vec3f d = p - base_;
  return {dot(d, right_), dot(d, up_), -dot(d, forward_)};
}

void draw_props(const Props& props, const PropAxes& axes, const Intrinsics& intrinsics, std::uint64_t seed,
                std::uint64_t frame, DepthImage depth) {
  Rng rng = Rng::for_item(seed, kPropStream, frame);
  if (props.mirror) draw_mirror(*props.mirror, axes, intrinsics, rng, depth);
  if (props.animal) draw_animal(*props.animal, axes, intrinsics, frame, rng, depth);
}

}  // namespace im2fit::lab
