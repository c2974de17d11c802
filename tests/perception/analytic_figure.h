// SPDX-License-Identifier: Apache-2.0
// A standing figure made of ellipsoids and capsules, ray-cast in closed form: truth for kernels without any mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/camera.h"
#include "core/joints.h"
#include "core/rng.h"

namespace im2fit::test {

struct Hit {
  double z = 0;  // mm, 0 = none
  Vec3f normal;  // unit, towards the camera
};

// Axis-aligned ellipsoid.
struct Ellipsoid {
  Vec3f centre;  // mm
  Vec3f radii;
};

struct Capsule {
  Vec3f a, b;
  float radius;
};

inline Hit nearer(Hit a, Hit b) {
  return b.z > 0 && (a.z == 0 || b.z < a.z) ? b : a;
}

// The ray is (tx, ty, 1) z.
inline Hit cast(const Ellipsoid& e, double tx, double ty) {
  const double rx = e.radii.x, ry = e.radii.y, rz = e.radii.z;
  const double dx = tx / rx, dy = ty / ry, dz = 1 / rz;
  const double ox = e.centre.x / rx, oy = e.centre.y / ry, oz = e.centre.z / rz;
  const double a = dx * dx + dy * dy + dz * dz, b = dx * ox + dy * oy + dz * oz;
  const double disc = b * b - a * (ox * ox + oy * oy + oz * oz - 1);
  if (disc <= 0) return {};
  const double z = (b - std::sqrt(disc)) / a;
  const double nx = (tx * z - e.centre.x) / (rx * rx), ny = (ty * z - e.centre.y) / (ry * ry),
               nz = (z - e.centre.z) / (rz * rz), n = std::sqrt(nx * nx + ny * ny + nz * nz);
  return {z, {static_cast<float>(nx / n), static_cast<float>(ny / n), static_cast<float>(nz / n)}};
}

inline Hit cast_sphere(Vec3f centre, float radius, double tx, double ty) {
  return cast(Ellipsoid{centre, {radius, radius, radius}}, tx, ty);
}

inline Hit cast(const Capsule& c, double tx, double ty) {
  Hit best = nearer(cast_sphere(c.a, c.radius, tx, ty), cast_sphere(c.b, c.radius, tx, ty));
  const double ax = c.b.x - c.a.x, ay = c.b.y - c.a.y, az = c.b.z - c.a.z;
  const double length2 = ax * ax + ay * ay + az * az;
  const auto off_axis = [&](double x, double y, double z, double out[3]) {
    const double s = (x * ax + y * ay + z * az) / length2;
    out[0] = x - s * ax, out[1] = y - s * ay, out[2] = z - s * az;
    return s;
  };
  double d[3], o[3];
  const double sd = off_axis(tx, ty, 1, d), so = off_axis(c.a.x, c.a.y, c.a.z, o);
  const double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], b = d[0] * o[0] + d[1] * o[1] + d[2] * o[2];
  const double r = c.radius, disc = b * b - a * (o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - r * r);
  if (disc <= 0 || a == 0) return best;
  const double z = (b - std::sqrt(disc)) / a, along = z * sd - so;
  if (along < 0 || along > 1) return best;
  Vec3f n = {static_cast<float>((z * d[0] - o[0]) / r), static_cast<float>((z * d[1] - o[1]) / r),
             static_cast<float>((z * d[2] - o[2]) / r)};
  return nearer(best, {z, n});
}

struct Figure {
  std::vector<Ellipsoid> ellipsoids;
  std::vector<Capsule> capsules;
  JointSet joints;
  Hit cast_ray(double tx, double ty) const {
    Hit best;
    for (const Ellipsoid& e : ellipsoids) best = nearer(best, cast(e, tx, ty));
    for (const Capsule& c : capsules) best = nearer(best, cast(c, tx, ty));
    return best;
  }
};

// About 1.72 m from crown to soles, trunk axis at (x, z); the camera looks at its middle. Crown at y = -830 + lift.
inline Figure standing_figure(float x, float z, float lift_mm = 0) {
  Figure f;
  const auto at = [&](float dx, float y, float dz = 0) { return Vec3f{x + dx, y + lift_mm, z + dz}; };
  f.ellipsoids = {{at(0, -710), {76, 120, 95}},        {at(0, -400), {165, 200, 115}},
                  {at(0, -180), {142, 210, 105}},      {at(0, 40), {172, 170, 120}},
                  {at(-70, -430, -60), {70, 70, 60}},  {at(70, -430, -60), {70, 70, 60}},
                  {at(-100, 870, -60), {45, 30, 120}}, {at(100, 870, -60), {45, 30, 120}}};
  f.capsules = {{at(0, -640), at(0, -520), 56},          {at(-150, -500), at(150, -500), 62},
                {at(-190, -490), at(-300, -220), 48},    {at(190, -490), at(300, -220), 48},
                {at(-300, -220), at(-390, 20, -30), 38}, {at(300, -220), at(390, 20, -30), 38},
                {at(-90, 80), at(-100, 460), 80},        {at(90, 80), at(100, 460), 80},
                {at(-100, 460), at(-100, 850), 52},      {at(100, 460), at(100, 850), 52}};
  JointSet& j = f.joints;
  j[Joint::HE] = at(0, -720), j[Joint::NE] = at(0, -540), j[Joint::TO] = at(0, -240);
  // The person faces the camera: their left is on the picture's right.
  j[Joint::LS] = at(180, -495), j[Joint::RS] = at(-180, -495);
  j[Joint::LE] = at(300, -220), j[Joint::RE] = at(-300, -220);
  j[Joint::LA] = at(390, 20, -30), j[Joint::RA] = at(-390, 20, -30);
  j[Joint::LH] = at(90, 60), j[Joint::RH] = at(-90, 60);
  j[Joint::LK] = at(100, 460), j[Joint::RK] = at(-100, 460);
  j[Joint::LF] = at(100, 850), j[Joint::RF] = at(-100, 850);
  j.confidence.fill(1.0F);
  return f;
}

struct FigureCloud {
  Intrinsics intrinsics;
  std::vector<float> x, y, z, nx, ny, nz;
  int valid_count = 0;
};

// Range noise along the ray, normals tilted by `normal_sd`, and a share of the normals missing. No libm but sqrt: the
// same cloud on every machine.
inline FigureCloud render_cloud(const Figure& figure, const Intrinsics& k, double noise_mm, double normal_sd,
                                double missing_normals, std::uint64_t seed) {
  FigureCloud c;
  c.intrinsics = k;
  const std::size_t count = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::vector<float>* a : {&c.x, &c.y, &c.z, &c.nx, &c.ny, &c.nz}) a->assign(count, nan);
  Rng rng(seed);
  std::size_t i = 0;
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u, ++i) {
      const double tx = (u - double{k.cx}) / double{k.fx}, ty = (v - double{k.cy}) / double{k.fy};
      const Hit hit = figure.cast_ray(tx, ty);
      if (hit.z == 0) continue;
      const double z = hit.z + noise_mm * double{rng.fast_normal()};
      c.x[i] = static_cast<float>(tx * z), c.y[i] = static_cast<float>(ty * z), c.z[i] = static_cast<float>(z);
      ++c.valid_count;
      const auto lean = [&] { return static_cast<float>(normal_sd) * rng.fast_normal(); };
      const Vec3f tilt = {lean(), lean(), lean()};  // braces: in this order
      if (rng.uniform() < missing_normals) continue;
      const Vec3f n = normalized(hit.normal + tilt);
      c.nx[i] = n.x, c.ny[i] = n.y, c.nz[i] = n.z;
    }
  }
  return c;
}

}  // namespace im2fit::test
