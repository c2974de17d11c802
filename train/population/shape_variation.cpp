// SPDX-License-Identifier: Apache-2.0
#include "train/population/shape_variation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "train/common/simd_clones.h"

namespace im2fit::lab {
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
IM2FIT_SIMD_CLONES void mark_within(std::span<const Vec3f> points, Vec3f centre, float reach,
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
IM2FIT_SIMD_CLONES void add_weights(std::span<const Vec3f> points, const Pair& pair, float size,
                                    float* __restrict sum) {
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
IM2FIT_SIMD_CLONES void add_warp(std::span<const Vec3f> points, const Warp& warp, Vec3f* __restrict offset) {
  constexpr float kFlat = 0.5F;                 // widths and depths count for less than heights
  constexpr float kHeightToWidth = 1 / 100.0F;  // a shape wider forwards is so by this of a millimetre
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

void raise_crown(const body::BodyModel& model, std::span<const Vec3f> rest, float up_mm, std::span<Vec3f> offset_mm) {
  constexpr float kCrownMm = 120;  // from the ears to the crown
  const Height height = height_of(model, rest);
  for (std::size_t v = 0; v < static_cast<std::size_t>(model.body_vertex_count()); ++v) {
    const float share = (rest[v].y - (height.high - kCrownMm)) / kCrownMm;
    if (share > 0) offset_mm[v].y += up_mm * share * share * (3 - 2 * share);
  }
}

namespace {

constexpr float kAsideMm = 190;  // of centres: arms hang farther

float between(Rng& rng, float least, float most) {
  return static_cast<float>(rng.uniform(static_cast<double>(least), static_cast<double>(most)));
}
float normal(Rng& rng, double sd) {
  return static_cast<float>(rng.normal() * sd);
}

// The part of a body between two shares of its height, and random places in it.
struct Part {
  std::span<const Vec3f> points;  // of the whole body
  Height height;
  float low, high;

  float draw_height(Rng& rng) const { return height.low + (height.high - height.low) * between(rng, low, high); }
  Vec3f draw_point(Rng& rng) const {
    for (;;) {
      const Vec3f p = points[static_cast<std::size_t>(rng.index(static_cast<int>(points.size())))];
      const float share = height.share(p.y);
      if (share >= low && share <= high && std::abs(p.x) <= kAsideMm) return p;
    }
  }
  // Mean depth of the trunk: arms hang farther aside.
  float axis_z() const {
    double depth_sum = 0;
    int depth_count = 0;
    for (const Vec3f& p : points) {
      const float share = height.share(p.y);
      if (share < 0.5F || share > 0.75F || std::abs(p.x) > kAsideMm) continue;
      depth_sum += static_cast<double>(p.z);
      ++depth_count;
    }
    return static_cast<float>(depth_sum / std::max(depth_count, 1));
  }
};

void add_mirrored_bumps(const Part& part, const Mirrored& m, Rng& rng, std::span<float> along) {
  const float size_mm = between(rng, m.bump_least_mm, m.bump_most_mm);
  for (int i = 0; i < m.bumps; ++i) {
    Pair pair;
    pair.centre = part.draw_point(rng);
    pair.reach = between(rng, m.bump_reach_least_mm, m.bump_reach_most_mm);
    const float size = between(rng, -1, 1) * size_mm;
    if (rng.uniform() < m.uneven_share) pair.image = between(rng, -1, 1);
    add_weights(part.points, pair, size, along.data());
  }
}

void add_slides(const Part& part, const Mirrored& m, Rng& rng, std::span<float> up) {
  for (int i = 0; i < m.slides; ++i) {
    Pair pair;
    pair.centre = part.draw_point(rng);
    pair.reach = between(rng, m.slide_reach_least_mm, m.slide_reach_most_mm);
    add_weights(part.points, pair, normal(rng, m.slide_sd_mm), up.data());
  }
}

void add_warps(const Part& part, const Mirrored& m, Rng& rng, std::span<Vec3f> offset_mm) {
  const float axis_z = part.axis_z();
  for (int i = 0; i < m.warps; ++i) {
    Warp warp;
    warp.centre = {0, part.draw_height(rng), axis_z + between(rng, -100, 100)};
    warp.reach = between(rng, m.warp_reach_least_mm, m.warp_reach_most_mm);
    warp.up_mm = normal(rng, 0.4 * m.warp_sd_mm);
    warp.forward_mm = normal(rng, m.warp_sd_mm);
    for (float* stretch : {&warp.wider, &warp.wider_forward, &warp.wider_up, &warp.deeper, &warp.leaning})
      *stretch = normal(rng, m.warp_stretch_sd);
    add_warp(part.points, warp, offset_mm.data());
  }
}

void add_shifts(const Part& part, const Mirrored& m, Rng& rng, std::span<Vec3f> offset_mm) {
  for (int i = 0; i < m.shifts; ++i) {
    const float centre = part.draw_height(rng);
    const float reach = between(rng, m.shift_reach_least_mm, m.shift_reach_most_mm);
    const float forward_mm = normal(rng, m.shift_sd_mm);
    for (std::size_t v = 0; v < part.points.size(); ++v) {
      const float y = (part.points[v].y - centre) / reach, left = 1 - y * y;
      if (left > 0) offset_mm[v].z += forward_mm * left * left;
    }
  }
}

}  // namespace

void add_mirrored(const body::BodyModel& model, std::span<const Vec3f> rest, const Mirrored& mirrored, Rng& rng,
                  std::span<Vec3f> offset_mm) {
  const Part part{rest.first(static_cast<std::size_t>(model.body_vertex_count())), height_of(model, rest),
                  mirrored.low, mirrored.high};
  std::vector<float> along(part.points.size()), up(part.points.size());
  add_mirrored_bumps(part, mirrored, rng, along);
  add_slides(part, mirrored, rng, up);
  const std::vector<std::uint8_t> all(part.points.size(), 1);
  const std::vector<Vec3f> normals = vertex_normals(model, rest, all);
  for (std::size_t v = 0; v < part.points.size(); ++v)
    offset_mm[v] = offset_mm[v] + normals[v] * along[v] + Vec3f{0, up[v], 0};
  add_warps(part, mirrored, rng, offset_mm);
  add_shifts(part, mirrored, rng, offset_mm);
}

}  // namespace im2fit::lab
