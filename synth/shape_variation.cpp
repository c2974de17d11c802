// SPDX-License-Identifier: Apache-2.0
#include "synth/shape_variation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "synth/clones.h"

namespace im2fit::synth {
namespace {

// Unit normals of the vertices that are wanted, zero for others.
std::vector<Vec3f> vertex_normals(const body::BodyModel& model, std::span<const Vec3f> rest,
                                  std::span<const std::uint8_t> wanted) {
  std::vector<Vec3f> normals(static_cast<std::size_t>(model.body_vertex_count()));
  const auto at = [](std::int32_t i) { return static_cast<std::size_t>(i); };
  for (const auto& q : model.body_quads()) {
    if ((wanted[at(q[0])] | wanted[at(q[1])] | wanted[at(q[2])] | wanted[at(q[3])]) == 0) continue;
    const Vec3f n = cross(rest[at(q[2])] - rest[at(q[0])], rest[at(q[3])] - rest[at(q[1])]);  // twice its area
    for (const std::int32_t i : q) normals[at(i)] = normals[at(i)] + n;
  }
  for (std::size_t v = 0; v < normals.size(); ++v) normals[v] = wanted[v] != 0 ? normalized(normals[v]) : Vec3f{};
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

// Marks the points within reach, and perhaps some at its very end.
IM2FIT_CLONES void mark_within(std::span<const Vec3f> points, Vec3f centre, float reach,
                               std::uint8_t* __restrict mark) {
  const Vec3f* __restrict point = points.data();
  const auto count = static_cast<int>(points.size());
  const float most = reach * reach * 1.00001F;
  for (int i = 0; i < count; ++i) {
    const float x = point[i].x - centre.x, y = point[i].y - centre.y, z = point[i].z - centre.z;
    mark[i] = static_cast<std::uint8_t>(mark[i] | (x * x + y * y + z * z < most ? 1 : 0));
  }
}

}  // namespace

void add_bumps(const body::BodyModel& model, std::span<const Vec3f> rest, const Bumps& bumps, float amplitude_mm,
               Rng& rng, std::span<Vec3f> offset_mm) {
  struct Bump {
    Vec3f centre;
    float reach, size;
  };
  const Height height = height_of(model, rest);
  std::vector<Bump> drawn;
  std::vector<std::uint8_t> wanted(static_cast<std::size_t>(model.body_vertex_count()));
  for (int i = 0; i < bumps.count; ++i) {
    Vec3f centre = rest[0];
    do {
      centre = rest[static_cast<std::size_t>(rng.index(model.body_vertex_count()))];
    } while (height.share(centre.y) < bumps.low || height.share(centre.y) > bumps.high ||
             std::abs(centre.x) > bumps.aside_mm);
    const float reach = static_cast<float>(
        rng.uniform(static_cast<double>(bumps.reach_least_mm), static_cast<double>(bumps.reach_most_mm)));
    const float size = static_cast<float>(rng.uniform(-1, 1)) * amplitude_mm;
    drawn.push_back({centre, reach, size});
    mark_within(rest.first(wanted.size()), centre, reach, wanted.data());
  }
  const std::vector<Vec3f> normals = vertex_normals(model, rest, wanted);
  for (std::size_t v = 0; v < wanted.size(); ++v) {
    if (wanted[v] == 0) continue;
    for (const Bump& bump : drawn) {
      const Vec3f d = rest[v] - bump.centre;
      const float far = 1 - dot(d, d) / (bump.reach * bump.reach);
      if (far > 0) offset_mm[v] = offset_mm[v] + normals[v] * (bump.size * far * far);
    }
  }
}

void add_asymmetry(const body::BodyModel& model, std::span<const Vec3f> rest, float amplitude_mm, Rng& rng,
                   std::span<Vec3f> offset_mm) {
  const std::vector<std::uint8_t> all(static_cast<std::size_t>(model.body_vertex_count()), 1);
  const std::vector<Vec3f> normals = vertex_normals(model, rest, all);
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
