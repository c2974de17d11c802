// SPDX-License-Identifier: Apache-2.0
#include "train/render/raster.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "train/common/simd_clones.h"

namespace im2fit::lab {
namespace {

constexpr int kSubpixelBits = 8;
constexpr std::int64_t kSubpixels = 1 << kSubpixelBits;
// Vertices farther out than this are not drawn: 2^14 px * 2^8 keeps every product of two differences below 2^48.
constexpr float kScreenMaxPx = 16384;

std::int32_t floor_to_pixel(std::int32_t x) {
  return x >> kSubpixelBits;
}
std::int32_t ceil_to_pixel(std::int32_t x) {
  return (x + static_cast<std::int32_t>(kSubpixels) - 1) >> kSubpixelBits;
}
std::int32_t least(std::int32_t a, std::int32_t b, std::int32_t c) {
  return std::min(std::min(a, b), c);
}
std::int32_t most(std::int32_t a, std::int32_t b, std::int32_t c) {
  return std::max(std::max(a, b), c);
}

}  // namespace

PixelBox whole(int width, int height) {
  return {0, 0, width, height};
}
PixelBox intersect(const PixelBox& a, const PixelBox& b) {
  return {std::max(a.u0, b.u0), std::max(a.v0, b.v0), std::min(a.u1, b.u1), std::min(a.v1, b.v1)};
}
PixelBox bounding(const PixelBox& a, const PixelBox& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.u0, b.u0), std::min(a.v0, b.v0), std::max(a.u1, b.u1), std::max(a.v1, b.v1)};
}
PixelBox grown(const PixelBox& box, int margin_px) {
  if (box.empty()) return box;
  return {box.u0 - margin_px, box.v0 - margin_px, box.u1 + margin_px, box.v1 + margin_px};
}

CleanView::CleanView(int w, int h)
    : width(w),
      height(h),
      inverse_depth(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)),
      cosine(inverse_depth.size()),
      label(inverse_depth.size()) {}

void clear(CleanView& view, const PixelBox& box) {
  if (box.empty()) return;
  const auto count = static_cast<std::size_t>(box.u1 - box.u0);
  for (int v = box.v0; v < box.v1; ++v) {
    const std::size_t at = view.at(box.u0, v);
    std::fill_n(&view.inverse_depth[at], count, 0.0F);
    std::fill_n(&view.cosine[at], count, std::uint8_t{0});
    std::fill_n(&view.label[at], count, std::uint8_t{kNothing});
  }
}

void copy_box(const CleanView& from, const PixelBox& box, CleanView& to) {
  if (box.empty()) return;
  const auto count = static_cast<std::size_t>(box.u1 - box.u0);
  for (int v = box.v0; v < box.v1; ++v) {
    const std::size_t at = from.at(box.u0, v);
    std::copy_n(&from.inverse_depth[at], count, &to.inverse_depth[at]);
    std::copy_n(&from.cosine[at], count, &to.cosine[at]);
    std::copy_n(&from.label[at], count, &to.label[at]);
  }
}

namespace {

// Inverse depth of a plane along a row of pixels, and at its last pixel.
struct PlaneRow {
  float start = 0, step = 0, end = 0, distance_mm = 0;
};

// Behind the camera all along the row, or behind another plane: both are lines, whose ends tell.
bool hidden(const PlaneRow& row, std::span<const PlaneRow> rows) {
  const auto behind = [&](const PlaneRow& other) {
    // Several times what rounding takes off along the row.
    const float slack =
        1e-6F * (std::fabs(row.start) + std::fabs(row.end) + std::fabs(other.start) + std::fabs(other.end));
    return row.start + slack < other.start && row.end + slack < other.end;
  };
  return behind({}) || std::any_of(rows.begin(), rows.end(), behind);
}

}  // namespace

namespace {

struct RoomRow {
  const float* inverse_depth;
  const float* distance_mm;  // of the plane seen
  float left, inverse_fx;    // of rays: x = (left + i) inverse_fx
  float rest;                // 1 + y^2
};
// A store of bytes may change anything the compiler cannot tell apart, and std::min is a branch to it: both keep the
// vectoriser away.
inline __attribute__((always_inline)) void incidence_row(const RoomRow& row, int count,
                                                         std::uint8_t* __restrict cosine,
                                                         std::uint8_t* __restrict label) {
  const float* __restrict q = row.inverse_depth;
  const float* __restrict distance = row.distance_mm;
  const float left = row.left, inverse_fx = row.inverse_fx, rest = row.rest;
  for (int i = 0; i < count; ++i) {
    const float x = (left + static_cast<float>(i)) * inverse_fx;
    const float scaled = distance[i] * q[i] / std::sqrt(x * x + rest) * 255.0F + 0.5F;
    cosine[i] = static_cast<std::uint8_t>(static_cast<int>(scaled < 255.0F ? scaled : 255.0F));
  }
  for (int i = 0; i < count; ++i) label[i] = q[i] > 0 ? kRoom : kNothing;
}

}  // namespace

IM2FIT_SIMD_CLONES void draw_room(std::span<const Plane> planes, const Intrinsics& k, const PixelBox& box,
                                  CleanView& view) {
  if (box.empty()) return;
  const int count = box.u1 - box.u0;
  std::vector<float> distance(static_cast<std::size_t>(count));
  std::vector<PlaneRow> rows;
  for (int v = box.v0; v < box.v1; ++v) {
    const std::size_t at = view.at(box.u0, v);
    float* q = &view.inverse_depth[at];
    std::fill_n(q, count, 0.0F);
    std::fill(distance.begin(), distance.end(), 0.0F);
    const float y = (static_cast<float>(v) - k.cy) / k.fy;
    rows.clear();
    for (const Plane& plane : planes) {
      // 1/z = n.r / d with the ray r = ((u - cx)/fx, y, 1); the nearest plane has the largest.
      const float step = plane.normal.x / (k.fx * plane.distance_mm);
      const float start =
          (plane.normal.y * y + plane.normal.z) / plane.distance_mm + step * (static_cast<float>(box.u0) - k.cx);
      rows.push_back({start, step, start + step * static_cast<float>(count - 1), plane.distance_mm});
    }
    for (const PlaneRow& row : rows) {
      if (hidden(row, rows)) continue;
      const float start = row.start, step = row.step, d = row.distance_mm;
      for (int i = 0; i < count; ++i) {
        const float candidate = start + step * static_cast<float>(i);
        const bool nearer = candidate > q[i];
        q[i] = nearer ? candidate : q[i];
        distance[static_cast<std::size_t>(i)] = nearer ? d : distance[static_cast<std::size_t>(i)];
      }
    }
    incidence_row({q, distance.data(), static_cast<float>(box.u0) - k.cx, 1 / k.fx, y * y + 1}, count,
                  &view.cosine[at], &view.label[at]);
  }
}

// Which column and row of pixels a vertex lies before, 16 bits each. On a pixel's column or row it gets a mark of its
// own, so that it counts as apart from vertices beside it.
std::uint32_t MeshRaster::cell_of(const Projected& p) {
  const auto part = [](std::int32_t x) {
    const auto cell = static_cast<std::uint32_t>(ceil_to_pixel(x)) & 0x7FFFU;
    return (x & (kSubpixels - 1)) == 0 ? cell | 0x8000U : cell;
  };
  return part(p.x) << 16 | part(p.y);
}

// Most of a body's triangles are smaller than a pixel and have no pixel's centre in their box: all their corners
// before one column, or before one row, and none on it.
bool MeshRaster::between_centres(const Triangle& t) const {
  const std::uint32_t a = cells_[static_cast<std::size_t>(t[0])];
  const std::uint32_t apart =
      (a ^ cells_[static_cast<std::size_t>(t[1])]) | (a ^ cells_[static_cast<std::size_t>(t[2])]);
  const bool marked_column = (a & 0x80000000U) != 0, marked_row = (a & 0x8000U) != 0;
  return ((apart >> 16) == 0 && !marked_column) || ((apart & 0xFFFFU) == 0 && !marked_row);
}

void MeshRaster::fill(std::span<const Vec3f> vertices, const Triangle& triangle, std::uint8_t label, bool closed,
                      Target& target) const {
  const Projected* a = &projected_[static_cast<std::size_t>(triangle[0])];
  const Projected* b = &projected_[static_cast<std::size_t>(triangle[1])];
  const Projected* c = &projected_[static_cast<std::size_t>(triangle[2])];
  constexpr std::int32_t kBad = std::numeric_limits<std::int32_t>::min();
  if (a->x == kBad || b->x == kBad || c->x == kBad) return;

  const std::int32_t u0 = std::max(ceil_to_pixel(least(a->x, b->x, c->x)), target.clip.u0);
  const std::int32_t u1 = std::min(floor_to_pixel(most(a->x, b->x, c->x)), target.clip.u1 - 1);
  if (u0 > u1) return;
  const std::int32_t v0 = std::max(ceil_to_pixel(least(a->y, b->y, c->y)), target.clip.v0);
  const std::int32_t v1 = std::min(floor_to_pixel(most(a->y, b->y, c->y)), target.clip.v1 - 1);
  if (v0 > v1) return;

  // Camera axes are right-handed with y down: an outward triangle facing the camera has negative area.
  std::int64_t area =
      static_cast<std::int64_t>(b->x - a->x) * (c->y - a->y) - static_cast<std::int64_t>(c->x - a->x) * (b->y - a->y);
  if (area == 0 || (closed && area > 0)) return;
  if (area < 0) {
    std::swap(b, c);
    area = -area;
  }
  PixelBox& box = target.touched;
  box = bounding(box, {u0, v0, u1 + 1, v1 + 1});

  struct Edge {
    std::int64_t value, per_u, per_v;
  };
  const auto edge = [&](const Projected& p, const Projected& r) {
    const std::int64_t dx = r.x - p.x;
    const std::int64_t dy = r.y - p.y;
    const bool top_left = dy < 0 || (dy == 0 && dx > 0);
    const std::int64_t value = dx * (v0 * kSubpixels - p.y) - dy * (u0 * kSubpixels - p.x) - (top_left ? 0 : 1);
    return Edge{value, -dy * kSubpixels, dx * kSubpixels};
  };
  Edge ab = edge(*a, *b);
  Edge bc = edge(*b, *c);
  Edge ca = edge(*c, *a);
  // Of those whose box holds a centre, many miss it.
  if (u0 == u1 && v0 == v1 && (ab.value | bc.value | ca.value) < 0) return;

  const float inverse_area = static_cast<float>(kSubpixels) / static_cast<float>(area);
  const float qb = b->inverse_z - a->inverse_z;
  const float qc = c->inverse_z - a->inverse_z;
  const float q_per_u = (qb * static_cast<float>(c->y - a->y) - qc * static_cast<float>(b->y - a->y)) * inverse_area;
  const float q_per_v = (qc * static_cast<float>(b->x - a->x) - qb * static_cast<float>(c->x - a->x)) * inverse_area;
  // Slivers have gradients of no meaning; the clamp keeps their depth between their corners'.
  const auto [q_low, q_high] = std::minmax({a->inverse_z, b->inverse_z, c->inverse_z});

  const Vec3f p = vertices[static_cast<std::size_t>(triangle[0])];
  const Vec3f n =
      cross(vertices[static_cast<std::size_t>(triangle[1])] - p, vertices[static_cast<std::size_t>(triangle[2])] - p);
  const float scale = std::sqrt(dot(n, n) * dot(p, p));
  const float cosine = scale > 0 ? std::fabs(dot(n, p)) / scale : 0;
  const auto cosine_byte = static_cast<std::uint8_t>(std::min(cosine * 255.0F + 0.5F, 255.0F));

  CleanView& view = target.view;
  const float du = static_cast<float>(u0) - static_cast<float>(a->x) / static_cast<float>(kSubpixels);
  for (std::int32_t v = v0; v <= v1; ++v) {
    const float dv = static_cast<float>(v) - static_cast<float>(a->y) / static_cast<float>(kSubpixels);
    const float q_row = a->inverse_z + q_per_v * dv + q_per_u * du;
    const std::size_t row = view.at(u0, v);
    std::int64_t e0 = ab.value, e1 = bc.value, e2 = ca.value;
    const int count = u1 - u0 + 1;
    for (int i = 0; i < count; ++i) {
      if ((e0 | e1 | e2) >= 0) {
        const float q = std::clamp(q_row + q_per_u * static_cast<float>(i), q_low, q_high);
        const std::size_t at = row + static_cast<std::size_t>(i);
        if (q > view.inverse_depth[at]) {
          view.inverse_depth[at] = q;
          view.cosine[at] = cosine_byte;
          view.label[at] = label;
        }
      }
      e0 += ab.per_u;
      e1 += bc.per_u;
      e2 += ca.per_u;
    }
    ab.value += ab.per_v;
    bc.value += bc.per_v;
    ca.value += ca.per_v;
  }
}

IM2FIT_SIMD_CLONES PixelBox MeshRaster::draw(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                                             std::span<const std::uint8_t> labels, bool closed, const Intrinsics& k,
                                             const PixelBox& clip, CleanView& view) {
  projected_.resize(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec3f p = vertices[i];
    projected_[i].x = std::numeric_limits<std::int32_t>::min();
    if (p.z < kNearMm) continue;
    const float q = 1 / p.z;
    const float u = p.x * k.fx * q + k.cx;
    const float v = p.y * k.fy * q + k.cy;
    if (std::fabs(u) > kScreenMaxPx || std::fabs(v) > kScreenMaxPx) continue;
    projected_[i] = {static_cast<std::int32_t>(std::floor(u * static_cast<float>(kSubpixels) + 0.5F)),
                     static_cast<std::int32_t>(std::floor(v * static_cast<float>(kSubpixels) + 0.5F)), q};
  }
  Target target{view, clip, {}};
  cells_.resize(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) cells_[i] = cell_of(projected_[i]);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!between_centres(triangles[t]))
      fill(vertices, triangles[t], labels.size() == 1 ? labels[0] : labels[t], closed, target);
  return target.touched;
}

}  // namespace im2fit::lab
