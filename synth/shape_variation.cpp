// SPDX-License-Identifier: Apache-2.0
#include "synth/shape_variation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace im2fit::synth {
namespace {

std::vector<Vec3f> vertex_normals(const body::BodyModel& model, std::span<const Vec3f> rest) {
  std::vector<Vec3f> normals(static_cast<std::size_t>(model.body_vertex_count()));
  for (const auto& t : model.body_triangles()) {
    const Vec3f a = rest[static_cast<std::size_t>(t[0])];
    const Vec3f n = cross(rest[static_cast<std::size_t>(t[1])] - a, rest[static_cast<std::size_t>(t[2])] - a);
    for (const std::int32_t i : t) {
      Vec3f& sum = normals[static_cast<std::size_t>(i)];
      sum = sum + n;
    }
  }
  for (Vec3f& n : normals) n = normalized(n);
  return normals;
}

struct Height {
  float low = 1e9F, high = -1e9F;
  float share(float y) const { return (y - low) / (high - low); }
};
Height height_of(const body::BodyModel& model, std::span<const Vec3f> rest) {
  Height h;
  for (const Vec3f& p : rest.first(static_cast<std::size_t>(model.body_vertex_count()))) {
    h.low = std::min(h.low, p.y);
    h.high = std::max(h.high, p.y);
  }
  return h;
}

}  // namespace

void add_bumps(const body::BodyModel& model, std::span<const Vec3f> rest, const Bumps& bumps, float amplitude_mm,
               Rng& rng, std::span<Vec3f> offset_mm) {
  const std::vector<Vec3f> normals = vertex_normals(model, rest);
  const Height height = height_of(model, rest);
  for (int i = 0; i < bumps.count; ++i) {
    Vec3f centre = rest[0];
    do {
      centre = rest[static_cast<std::size_t>(rng.index(model.body_vertex_count()))];
    } while (height.share(centre.y) < bumps.low || height.share(centre.y) > bumps.high ||
             std::abs(centre.x) > bumps.aside_mm);
    const float reach = static_cast<float>(
        rng.uniform(static_cast<double>(bumps.reach_least_mm), static_cast<double>(bumps.reach_most_mm)));
    const float size = static_cast<float>(rng.uniform(-1, 1)) * amplitude_mm;
    for (std::size_t v = 0; v < normals.size(); ++v) {
      const Vec3f d = rest[v] - centre;
      const float far = 1 - dot(d, d) / (reach * reach);
      if (far > 0) offset_mm[v] = offset_mm[v] + normals[v] * (size * far * far);
    }
  }
}

void add_asymmetry(const body::BodyModel& model, std::span<const Vec3f> rest, float amplitude_mm, Rng& rng,
                   std::span<Vec3f> offset_mm) {
  const std::vector<Vec3f> normals = vertex_normals(model, rest);
  const Height height = height_of(model, rest);
  const float lean = static_cast<float>(rng.uniform(-1, 1)) * amplitude_mm;
  const float fuller = static_cast<float>(rng.uniform(-0.5, 0.5)) * amplitude_mm;
  constexpr float kHalfWidthMm = 200;
  for (std::size_t v = 0; v < normals.size(); ++v) {
    // Zero at the floor and at the crown, so that stature and stance stay.
    const float wave = std::sin(std::numbers::pi_v<float> * std::clamp(height.share(rest[v].y), 0.0F, 1.0F));
    const float side = std::clamp(rest[v].x / kHalfWidthMm, -1.0F, 1.0F);
    offset_mm[v] = offset_mm[v] + Vec3f{lean * wave, 0, 0} + normals[v] * (fuller * wave * side);
  }
}

}  // namespace im2fit::synth
