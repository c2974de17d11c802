// SPDX-License-Identifier: Apache-2.0
// Rooms of planes, boxes and capsule people, seen by ray casting in closed form: truth without the code under test.
// World axes: x right, y up, z away from the camera, mm; the camera stands above the origin.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/camera.h"
#include "core/rng.h"

// Not im2fit::test: analytic_figure.h has shapes of the same names there, and one program holds both.
namespace im2fit::room_test {

struct Capsule {
  Vec3f a, b;
  float radius = 0;
  int owner = 0;  // person number, from 1
};
struct Box {
  Vec3f low, high;
};

inline constexpr double kKinectNoise = 0.5;  // raw steps, for render()

struct Scene {
  int width = 480, height = 640;  // portrait
  float focal = 575.8F;
  float camera_height = 1000;
  float pitch_deg = 0;  // looking down is positive
  bool floor = true;
  float wall_z = 0;  // 0: none
  std::vector<Capsule> capsules;
  std::vector<Box> boxes;

  Intrinsics intrinsics() const {
    return {width, height, focal, focal, 0.5F * static_cast<float>(width - 1), 0.5F * static_cast<float>(height - 1)};
  }
  float sin_pitch() const { return std::sin(pitch_deg * std::numbers::pi_v<float> / 180); }
  float cos_pitch() const { return std::cos(pitch_deg * std::numbers::pi_v<float> / 180); }
  Vec3f up_in_camera() const { return {0, -cos_pitch(), -sin_pitch()}; }
  Vec3f to_camera(Vec3f world) const {
    const float y = world.y - camera_height;
    return {world.x, -cos_pitch() * y - sin_pitch() * world.z, -sin_pitch() * y + cos_pitch() * world.z};
  }
};

struct Picture {
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> owner;  // 0 none, 255 floor, wall and boxes, else the person
  int width = 0, height = 0;
  DepthView view() const { return {depth.data(), width, height}; }
};

inline float hit_sphere(Vec3f o, Vec3f d, Vec3f c, float r) {
  const Vec3f m = o - c;
  const float a = dot(d, d), b = dot(m, d), q = b * b - a * (dot(m, m) - r * r);
  return q < 0 ? 1e9F : (-b - std::sqrt(q)) / a;
}
inline float hit_capsule(Vec3f o, Vec3f d, const Capsule& k) {
  float best = std::min(hit_sphere(o, d, k.a, k.radius), hit_sphere(o, d, k.b, k.radius));
  const Vec3f axis = k.b - k.a;
  const float length2 = dot(axis, axis);
  if (length2 < 1) return best;
  const Vec3f m = o - k.a;
  const Vec3f dp = d - axis * (dot(d, axis) / length2);
  const Vec3f mp = m - axis * (dot(m, axis) / length2);
  const float a = dot(dp, dp), b = dot(mp, dp), q = b * b - a * (dot(mp, mp) - k.radius * k.radius);
  if (q < 0 || a < 1e-12F) return best;
  const float t = (-b - std::sqrt(q)) / a;
  const float s = dot(m + d * t, axis) / length2;
  return s >= 0 && s <= 1 ? std::min(best, t) : best;
}
inline float hit_box(Vec3f o, Vec3f d, const Box& b) {
  float near = -1e9F, far = 1e9F;
  const auto slab = [&](float p, float v, float lo, float hi) {
    if (std::fabs(v) < 1e-9F) {
      if (p < lo || p > hi) near = 1e9F;
      return;
    }
    const float t0 = (lo - p) / v, t1 = (hi - p) / v;
    near = std::max(near, std::min(t0, t1));
    far = std::min(far, std::max(t0, t1));
  };
  slab(o.x, d.x, b.low.x, b.high.x);
  slab(o.y, d.y, b.low.y, b.high.y);
  slab(o.z, d.z, b.low.z, b.high.z);
  return near <= far && near > 0 ? near : 1e9F;
}

// Pixels a capsule may show in, all of the picture where it is near the camera.
struct PixelBounds {
  float u_min = -1, v_min = -1, u_max = 1e9F, v_max = 1e9F;
  bool holds(int u, int v) const {
    const float x = static_cast<float>(u), y = static_cast<float>(v);
    return x >= u_min && x <= u_max && y >= v_min && y <= v_max;
  }
};
inline PixelBounds bounds_of(const Scene& s, const Capsule& c) {
  const Intrinsics k = s.intrinsics();
  PixelBounds b = {1e9F, 1e9F, -1e9F, -1e9F};
  for (const Vec3f end : {s.to_camera(c.a), s.to_camera(c.b)}) {
    if (end.z < 400 + c.radius) return {};
    // A sphere's outline leaves the circle of its radius by less than a fifth within 60 degrees of view.
    const float reach = 1.2F * c.radius * k.fx / (end.z - c.radius) + 2;
    const float u = end.x * k.fx / end.z + k.cx, v = end.y * k.fy / end.z + k.cy;
    b = {std::min(b.u_min, u - reach), std::min(b.v_min, v - reach), std::max(b.u_max, u + reach),
         std::max(b.v_max, v + reach)};
  }
  return b;
}

// `noise_raw`: spread in 11-bit disparity steps (0: exact, rounded to mm); Kinect's is about 0.5 and it quantises.
inline Picture render(const Scene& s, double noise_raw = 0, std::uint64_t seed = 1) {
  Picture p;
  p.width = s.width;
  p.height = s.height;
  const Intrinsics k = s.intrinsics();
  const Vec3f o = {0, s.camera_height, 0};
  const Vec3f down = {0, -s.cos_pitch(), -s.sin_pitch()};
  const Vec3f forward = {0, -s.sin_pitch(), s.cos_pitch()};
  std::vector<PixelBounds> bounds;
  for (const Capsule& c : s.capsules) bounds.push_back(bounds_of(s, c));
  Rng rng(seed);
  for (int v = 0; v < s.height; ++v) {
    for (int u = 0; u < s.width; ++u) {
      const float rx = (static_cast<float>(u) - k.cx) / k.fx, ry = (static_cast<float>(v) - k.cy) / k.fy;
      const Vec3f d = Vec3f{rx, 0, 0} + down * ry + forward;  // t along it is the depth
      float t = 1e9F;
      std::uint8_t owner = 0;
      const auto nearer = [&](float hit, int who) {
        if (hit > 1 && hit < t) {
          t = hit;
          owner = static_cast<std::uint8_t>(who);
        }
      };
      if (s.floor && d.y < -1e-6F) nearer(-o.y / d.y, 255);
      if (s.wall_z > 0) nearer(s.wall_z / d.z, 255);
      for (const Box& b : s.boxes) nearer(hit_box(o, d, b), 255);
      for (std::size_t i = 0; i < s.capsules.size(); ++i)
        if (bounds[i].holds(u, v)) nearer(hit_capsule(o, d, s.capsules[i]), s.capsules[i].owner);
      double z = static_cast<double>(t);
      if (noise_raw > 0 && z < 8000) {
        constexpr double kStep = 2.85e-6;  // 1/mm
        z = 1.0 / (kStep * std::round(1.0 / z / kStep + rng.normal(0, noise_raw)));
      }
      p.depth.push_back(z < 8000 && z > 400 ? static_cast<std::uint16_t>(std::lround(z)) : std::uint16_t{0});
      p.owner.push_back(p.depth.back() == 0 ? std::uint8_t{0} : owner);
    }
  }
  return p;
}

// 1.76 m tall, facing the camera; hands 300 mm off the hips.
inline std::vector<Capsule> person_at(float x, float z, int owner = 1) {
  const auto at = [&](float dx, float y, float dz = 0) { return Vec3f{x + dx, y, z + dz}; };
  std::vector<Capsule> c = {{at(0, 1620), at(0, 1670), 90, owner},      {at(0, 1450), at(0, 1600), 55, owner},
                            {at(-110, 1400), at(110, 1400), 75, owner}, {at(0, 950), at(0, 1350), 115, owner},
                            {at(-70, 930), at(-80, 1370), 95, owner},   {at(70, 930), at(80, 1370), 95, owner}};
  for (const float s : {-1.0F, 1.0F}) {
    c.push_back({at(s * 170, 1390), at(s * 270, 1120), 48, owner});
    c.push_back({at(s * 270, 1120), at(s * 380, 850), 40, owner});
    c.push_back({at(s * 85, 900), at(s * 110, 480), 78, owner});
    c.push_back({at(s * 110, 480), at(s * 120, 80), 50, owner});
    c.push_back({at(s * 120, 40, 30), at(s * 130, 35, -150), 35, owner});
  }
  return c;
}

// In profile to the camera, no shoulders on either side of the head, one leg before the other, an arm along the
// trunk: a candidate, not confirmed by its shape.
inline std::vector<Capsule> profile_at(float x, float z) {
  const float away = std::sqrt(x * x + z * z), cosine = z / away, sine = x / away;
  const auto at = [&](float dx, float y, float dz = 0) {
    return Vec3f{x + dx * cosine + dz * sine, y, z - dx * sine + dz * cosine};
  };
  return {{at(0, 1600), at(15, 1650), 95, 1},
          {at(-10, 1430), at(-10, 1580), 62, 1},
          {at(-15, 950), at(-5, 1380), 118, 1},
          {at(-20, 1390, -85), at(-30, 1120, -95), 48, 1},
          {at(-30, 1120, -95), at(30, 880, -100), 38, 1},
          {at(20, 900, -60), at(40, 480, -70), 80, 1},
          {at(40, 480, -70), at(30, 80, -70), 52, 1},
          {at(-30, 900, 60), at(-60, 480, 70), 80, 1},
          {at(-60, 480, 70), at(-90, 80, 70), 52, 1},
          {at(30, 40, -70), at(190, 35, -70), 36, 1},
          {at(-90, 40, 70), at(60, 35, 70), 36, 1}};
}
// A Kinect at half its resolution, 1.1 m high, before a wall.
inline Scene room_at_320() {
  Scene s;
  s.width = 320;
  s.height = 240;
  s.focal = 287.9F;
  s.camera_height = 1100;
  s.pitch_deg = 4;
  s.wall_z = 4800;
  return s;
}

inline void add(Scene& scene, const std::vector<Capsule>& person) {
  scene.capsules.insert(scene.capsules.end(), person.begin(), person.end());
}

}  // namespace im2fit::room_test
