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

// Smooth weight about a centre and about its image, 1 there and 0 at the end of reach; the larger counts where both
// do.
struct Pair {
  Vec3f centre;
  float reach = 0;
  float image = 1;  // times its own weight
};
IM2FIT_CLONES void add_weights(std::span<const Vec3f> points, const Pair& pair, float size, float* __restrict sum) {
  const Vec3f* __restrict point = points.data();
  const auto count = static_cast<int>(points.size());
  const Vec3f c = pair.centre;
  const float over = 1 / (pair.reach * pair.reach), image = pair.image;
  for (int i = 0; i < count; ++i) {
    const float x = point[i].x - c.x, mirrored = point[i].x + c.x, y = point[i].y - c.y, z = point[i].z - c.z;
    const float beside = y * y + z * z;
    const float here_left = 1 - (x * x + beside) * over, there_left = 1 - (mirrored * mirrored + beside) * over;
    const float here = here_left > 0 ? here_left * here_left : 0.0F;
    const float there = there_left > 0 ? image * there_left * there_left : 0.0F;
    sum[i] += size * (std::fabs(there) > here ? there : here);
  }
}

struct Warp {
  Vec3f centre;
  float reach = 0;
  float up_mm = 0, forward_mm = 0;
  // Of a millimetre from the centre: of width, more so forwards and upwards; of depth; forwards by height.
  float wider = 0, wider_forward = 0, wider_up = 0, deeper = 0, leaning = 0;
};
IM2FIT_CLONES void add_warp(std::span<const Vec3f> points, const Warp& warp, Vec3f* __restrict offset) {
  constexpr float kFlat = 0.5F;                 // widths and depths count for less than heights
  constexpr float kHeightToWidth = 1 / 100.0F;  // what is wider forwards is so by this of a millimetre
  const Vec3f* __restrict point = points.data();
  const auto count = static_cast<int>(points.size());
  const Warp w = warp;
  const float over = 1 / (w.reach * w.reach);
  for (int i = 0; i < count; ++i) {
    const float x = point[i].x - w.centre.x, y = point[i].y - w.centre.y, z = point[i].z - w.centre.z;
    const float left = 1 - (kFlat * x * x + y * y + kFlat * z * z) * over;
    const float weight = left > 0 ? left * left : 0.0F;
    offset[i].x += weight * x * (w.wider + (w.wider_forward * z + w.wider_up * y) * kHeightToWidth);
    offset[i].y += weight * w.up_mm;
    offset[i].z += weight * (w.forward_mm + w.deeper * z + w.leaning * y);
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

void add_mirrored(const body::BodyModel& model, std::span<const Vec3f> rest, const Mirrored& mirrored, Rng& rng,
                  std::span<Vec3f> offset_mm) {
  constexpr float kLow = 0.45F, kHigh = 0.82F, kAsideMm = 190;  // centres, shares of the height
  const std::span<const Vec3f> points = rest.first(static_cast<std::size_t>(model.body_vertex_count()));
  const Height height = height_of(model, rest);
  const auto between = [&](float least, float most) {
    return static_cast<float>(rng.uniform(static_cast<double>(least), static_cast<double>(most)));
  };
  const auto normal = [&](double sd) { return static_cast<float>(rng.normal() * sd); };
  const auto on_trunk = [&] {
    for (;;) {
      const Vec3f p = points[static_cast<std::size_t>(rng.index(model.body_vertex_count()))];
      const float share = height.share(p.y);
      if (share >= kLow && share <= kHigh && std::abs(p.x) <= kAsideMm) return p;
    }
  };

  std::vector<float> along(points.size()), up(points.size());
  const float size_mm = between(mirrored.bump_least_mm, mirrored.bump_most_mm);
  for (int i = 0; i < mirrored.bumps; ++i) {
    Pair pair;
    pair.centre = on_trunk();
    pair.reach = between(mirrored.bump_reach_least_mm, mirrored.bump_reach_most_mm);
    const float size = between(-1, 1) * size_mm;
    if (rng.uniform() < mirrored.uneven_share) pair.image = between(-1, 1);
    add_weights(points, pair, size, along.data());
  }
  for (int i = 0; i < mirrored.slides; ++i) {
    Pair pair;
    pair.centre = on_trunk();
    pair.reach = between(mirrored.slide_reach_least_mm, mirrored.slide_reach_most_mm);
    add_weights(points, pair, normal(mirrored.slide_sd_mm), up.data());
  }
  const std::vector<std::uint8_t> all(points.size(), 1);
  const std::vector<Vec3f> normals = vertex_normals(model, rest, all);
  for (std::size_t v = 0; v < points.size(); ++v)
    offset_mm[v] = offset_mm[v] + normals[v] * along[v] + Vec3f{0, up[v], 0};

  // The trunk's axis: arms hang farther aside.
  double depth_sum = 0;
  int depth_count = 0;
  for (const Vec3f& p : points) {
    const float share = height.share(p.y);
    if (share < 0.5F || share > 0.75F || std::abs(p.x) > kAsideMm) continue;
    depth_sum += static_cast<double>(p.z);
    ++depth_count;
  }
  const auto axis_z = static_cast<float>(depth_sum / std::max(depth_count, 1));
  for (int i = 0; i < mirrored.warps; ++i) {
    Warp warp;
    warp.centre = {0, height.low + (height.high - height.low) * between(kLow, kHigh), axis_z + between(-100, 100)};
    warp.reach = between(mirrored.warp_reach_least_mm, mirrored.warp_reach_most_mm);
    warp.up_mm = normal(0.4 * mirrored.warp_sd_mm);
    warp.forward_mm = normal(mirrored.warp_sd_mm);
    for (float* stretch : {&warp.wider, &warp.wider_forward, &warp.wider_up, &warp.deeper, &warp.leaning})
      *stretch = normal(mirrored.warp_stretch_sd);
    add_warp(points, warp, offset_mm.data());
  }
}

}  // namespace im2fit::synth
