// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/body_surface.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "body/model_data.h"

namespace im2fit::body {
namespace {

constexpr std::size_t kCellsMax = 1U << 18;
constexpr float kCellMm = 20;           // a little more than the mesh's edges: few candidates a cell
constexpr float kCoveredWeight = 0.2F;  // of segments that clothes cover in a vertex: hems reach over ankle and wrist
constexpr float kLimbWeight = 0.1F;  // of a segment's weight in a vertex, from which the vertex belongs to its limb

std::uint8_t limb_of(Segment s) {
  switch (s) {
    case Segment::left_upper_arm:
    case Segment::left_lower_arm:
    case Segment::left_hand:
      return kLeftArm;
    case Segment::right_upper_arm:
    case Segment::right_lower_arm:
    case Segment::right_hand:
      return kRightArm;
    case Segment::left_upper_leg:
    case Segment::left_lower_leg:
    case Segment::left_foot:
      return kLeftLeg;
    case Segment::right_upper_leg:
    case Segment::right_lower_leg:
    case Segment::right_foot:
      return kRightLeg;
    default:
      return kTrunk;
  }
}

bool touches_cloth(Segment s, bool hands) {
  if (s == Segment::left_hand || s == Segment::right_hand) return hands;
  return s != Segment::head && s != Segment::left_foot && s != Segment::right_foot;
}

// Closest point of a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5), as shares of its corners.
std::array<float, 3> closest(Vec3f p, Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a;
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3f bp = p - b;
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) {
    const float v = d1 / (d1 - d3);
    return {1 - v, v, 0};
  }
  const Vec3f cp = p - c;
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) {
    const float w = d2 / (d2 - d6);
    return {1 - w, 0, w};
  }
  const float va = d3 * d6 - d5 * d4;
  const float e = d4 - d3, f = d5 - d6;
  if (va <= 0 && e >= 0 && f >= 0 && e + f > 0) {
    const float w = e / (e + f);
    return {0, 1 - w, w};
  }
  const float sum = va + vb + vc;
  if (!(sum > 0)) return {1, 0, 0};  // a needle
  const float v = vb / sum, w = vc / sum;
  return {1 - v - w, v, w};
}

}  // namespace

BodySurface::BodySurface(const BodyModel& model, bool hands) {
  const BodyModel::Data& d = model.data();
  const auto count = static_cast<std::size_t>(model.body_vertex_count());
  std::vector<std::uint8_t> counts(count, 0);
  limbs_.assign(count, 0);
  for (std::size_t v = 0; v < count; ++v) {
    const SkinRecord& s = d.skin[v];
    float covered = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      covered += touches_cloth(static_cast<Segment>(s.segment[k]), hands) ? s.weight[k] : 0;
      if (k == 0 || s.weight[k] > kLimbWeight) limbs_[v] |= limb_of(static_cast<Segment>(s.segment[k]));
    }
    counts[v] = covered > kCoveredWeight ? 1 : 0;
    if (counts[v] != 0) vertices_.push_back(static_cast<std::int32_t>(v));
  }
  for (const auto& t : model.body_triangles()) {
    bool all = true;
    for (const std::int32_t v : t) all = all && counts[static_cast<std::size_t>(v)] != 0;
    if (all) triangles_.push_back(t);
  }
  fan_first_.assign(count + 1, 0);
  for (const auto& t : triangles_)
    for (const std::int32_t v : t) ++fan_first_[static_cast<std::size_t>(v) + 1];
  for (std::size_t v = 0; v < count; ++v) fan_first_[v + 1] += fan_first_[v];
  fan_.resize(3 * triangles_.size());
  std::vector<std::int32_t> next(fan_first_.begin(), fan_first_.end() - 1);
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (const std::int32_t v : triangles_[t])
      fan_[static_cast<std::size_t>(next[static_cast<std::size_t>(v)]++)] = static_cast<std::int32_t>(t);
  std::vector<std::int32_t> about;
  for (std::size_t v = 0; v < count; ++v) {
    about.clear();
    for (std::int32_t k = fan_first_[v]; k < fan_first_[v + 1]; ++k)
      for (const std::int32_t corner : triangles_[static_cast<std::size_t>(fan_[static_cast<std::size_t>(k)])])
        if (corner != static_cast<std::int32_t>(v)) about.push_back(corner);
    std::sort(about.begin(), about.end());
    about.erase(std::unique(about.begin(), about.end()), about.end());
    ring_first_.push_back(static_cast<std::int32_t>(ring_.size()));
    ring_.insert(ring_.end(), about.begin(), about.end());
  }
  ring_first_.push_back(static_cast<std::int32_t>(ring_.size()));
  for (auto* list : {&begin_, &end_, &begin_normal_, &end_normal_}) list->resize(count);
  cell_first_.resize(kCellsMax + 1);
  candidates_.resize(vertices_.size());
  vertex_cell_.resize(vertices_.size());
}

void BodySurface::normals(std::span<const std::array<std::int32_t, 3>> triangles,
                          std::span<const std::int32_t> vertices, std::span<const Vec3f> positions,
                          std::span<Vec3f> out) {
  for (const std::int32_t v : vertices) out[static_cast<std::size_t>(v)] = {};
  for (const auto& t : triangles) {
    const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
               c = static_cast<std::size_t>(t[2]);
    const Vec3f n = cross(positions[b] - positions[a], positions[c] - positions[a]);
    out[a] = out[a] + n;
    out[b] = out[b] + n;
    out[c] = out[c] + n;
  }
  for (const std::int32_t v : vertices)
    out[static_cast<std::size_t>(v)] = normalized(out[static_cast<std::size_t>(v)]);
}

void BodySurface::end_at(std::span<const Vec3f> posed) {
  assert(posed.size() >= begin_.size());
  begin_.swap(end_);
  begin_normal_.swap(end_normal_);
  float farthest = 0;
  for (const std::int32_t v : vertices_) {
    const auto i = static_cast<std::size_t>(v);
    end_[i] = posed[i];
    const Vec3f moved = end_[i] - begin_[i];
    farthest = std::max(farthest, dot(moved, moved));
  }
  moved_mm_ = std::sqrt(farthest);
  normals(triangles_, vertices_, end_, end_normal_);
}

void BodySurface::advance(std::span<const Vec3f> posed) {
  end_at(posed);
  build_grid();
}

void BodySurface::put(std::span<const Vec3f> posed) {
  end_at(posed);
  begin_ = end_;  // same sizes: no allocation
  begin_normal_ = end_normal_;
  moved_mm_ = 0;
  build_grid();
}

int BodySurface::cell(float value, float low, int count) const {
  const int i = static_cast<int>((value - low) / cell_mm_);
  return i < 0 ? 0 : i >= count ? count - 1 : i;
}

void BodySurface::build_grid() {
  Vec3f low = begin_[static_cast<std::size_t>(vertices_[0])], high = low;
  for (const std::int32_t v : vertices_) {
    const Vec3f p = begin_[static_cast<std::size_t>(v)];
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  low_ = low;
  cell_mm_ = kCellMm;
  const auto size = [&](float from, float to) {
    const float cells = (to - from) / cell_mm_;
    return cells < 1023 ? static_cast<int>(cells) + 1 : 1024;
  };
  for (;;) {
    cells_ = {size(low.x, high.x), size(low.y, high.y), size(low.z, high.z)};
    const std::size_t all = static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1]) *
                            static_cast<std::size_t>(cells_[2]);
    if (all <= kCellsMax) break;
    cell_mm_ *= 1.25F;  // a giant: coarser cells find the same, more slowly
  }
  const std::size_t all =
      static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1]) * static_cast<std::size_t>(cells_[2]);
  std::fill_n(cell_first_.begin(), all + 1, 0);
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Vec3f p = begin_[static_cast<std::size_t>(vertices_[i])];
    const int at = (cell(p.z, low_.z, cells_[2]) * cells_[1] + cell(p.y, low_.y, cells_[1])) * cells_[0] +
                   cell(p.x, low_.x, cells_[0]);
    vertex_cell_[i] = at;
    ++cell_first_[static_cast<std::size_t>(at)];
  }
  // Ends of cells, which filling them from behind makes their beginnings.
  std::int32_t end = 0;
  for (std::size_t c = 0; c <= all; ++c) cell_first_[c] = end += cell_first_[c];
  for (std::size_t i = vertices_.size(); i-- > 0;) {
    const auto v = static_cast<std::size_t>(vertices_[i]);
    candidates_[static_cast<std::size_t>(--cell_first_[static_cast<std::size_t>(vertex_cell_[i])])] = {
        begin_[v], begin_normal_[v], vertices_[i], limbs_[v]};
  }
}

bool BodySurface::nearest(Vec3f point, Vec3f facing, float cosine, std::uint8_t limbs, float reach_mm,
                          std::int32_t& hint, SkinPlace& place) const {
  float best = reach_mm * reach_mm, reach = reach_mm;
  std::int32_t found = -1;
  const auto consider = [&](const Candidate& c) {
    const Vec3f d = c.at - point;
    const float squared = dot(d, d);
    if (squared >= best || (c.limbs & limbs) == 0 || dot(facing, c.facing) <= cosine) return;
    best = squared;
    found = c.vertex;
  };
  if (hint >= 0) {
    const auto i = static_cast<std::size_t>(hint);
    consider({begin_[i], begin_normal_[i], hint, limbs_[i]});
    if (found >= 0) reach = std::sqrt(best);
  }
  const int x0 = cell(point.x - reach, low_.x, cells_[0]), x1 = cell(point.x + reach, low_.x, cells_[0]);
  const int y0 = cell(point.y - reach, low_.y, cells_[1]), y1 = cell(point.y + reach, low_.y, cells_[1]);
  const int z0 = cell(point.z - reach, low_.z, cells_[2]), z1 = cell(point.z + reach, low_.z, cells_[2]);
  for (int z = z0; z <= z1; ++z)
    for (int y = y0; y <= y1; ++y) {
      const int row = (z * cells_[1] + y) * cells_[0];
      const std::int32_t from = cell_first_[static_cast<std::size_t>(row + x0)];
      const std::int32_t to = cell_first_[static_cast<std::size_t>(row + x1 + 1)];
      for (std::int32_t k = from; k < to; ++k) consider(candidates_[static_cast<std::size_t>(k)]);
    }
  hint = found;
  return found >= 0 && closest_about(found, point, place, false);
}

// Over neighbours to ever nearer vertices; -1: where it begins is out of reach.
std::int32_t BodySurface::walk(Vec3f point, Vec3f facing, float cosine, std::uint8_t limbs, float reach_mm,
                               std::int32_t from, bool at_end) const {
  const auto& position = at_end ? end_ : begin_;
  const auto& normal = at_end ? end_normal_ : begin_normal_;
  float best = reach_mm * reach_mm;
  std::int32_t found = -1;
  const auto consider = [&](std::int32_t v) {
    const auto i = static_cast<std::size_t>(v);
    const Vec3f d = position[i] - point;
    const float squared = dot(d, d);
    if (squared >= best || (limbs_[i] & limbs) == 0 || dot(facing, normal[i]) <= cosine) return;
    best = squared;
    found = v;
  };
  consider(from);
  for (std::int32_t at = -1; at != found;) {
    at = found;
    for (std::int32_t k = ring_first_[static_cast<std::size_t>(at)];
         k < ring_first_[static_cast<std::size_t>(at) + 1]; ++k)
      consider(ring_[static_cast<std::size_t>(k)]);
  }
  return found;
}

bool BodySurface::follow(Vec3f point, Vec3f facing, float cosine, std::uint8_t limbs, float reach_mm,
                         std::int32_t& hint, SkinPlace& place) const {
  const std::int32_t last = hint, found = walk(point, facing, cosine, limbs, reach_mm, last, false);
  if (found < 0) return nearest(point, facing, cosine, limbs, reach_mm, hint, place);
  hint = found;
  return closest_from(last, found, point, place, false);
}

bool BodySurface::follow_at_end(Vec3f point, Vec3f facing, float cosine, std::uint8_t limbs, float reach_mm,
                                std::int32_t& hint, SkinPlace& place) const {
  const std::int32_t last = hint;
  hint = walk(point, facing, cosine, limbs, reach_mm, last, true);
  return hint >= 0 && closest_from(last, hint, point, place, true);
}

bool BodySurface::closest_from(std::int32_t last, std::int32_t found, Vec3f point, SkinPlace& place,
                               bool at_end) const {
  // Still over the inside of its triangle.
  if (found == last && place.triangle >= 0) {
    const auto& position = at_end ? end_ : begin_;
    const auto& t = triangles_[static_cast<std::size_t>(place.triangle)];
    const auto corner = [&](std::size_t i) { return position[static_cast<std::size_t>(t[i])]; };
    const auto share = closest(point, corner(0), corner(1), corner(2));
    const bool about = t[0] == found || t[1] == found || t[2] == found;
    if (about && share[0] > 0 && share[1] > 0 && share[2] > 0) {
      place.share = share;
      return true;
    }
  }
  return closest_about(found, point, place, at_end);
}

bool BodySurface::closest_about(std::int32_t vertex, Vec3f point, SkinPlace& place, bool at_end) const {
  const auto& position = at_end ? end_ : begin_;
  const auto v = static_cast<std::size_t>(vertex);
  float least = 1e30F;
  place.triangle = -1;
  for (std::int32_t k = fan_first_[v]; k < fan_first_[v + 1]; ++k) {
    const std::int32_t triangle = fan_[static_cast<std::size_t>(k)];
    const auto& t = triangles_[static_cast<std::size_t>(triangle)];
    const auto corner = [&](std::size_t i) { return position[static_cast<std::size_t>(t[i])]; };
    const auto share = closest(point, corner(0), corner(1), corner(2));
    const Vec3f d = corner(0) * share[0] + corner(1) * share[1] + corner(2) * share[2] - point;
    const float squared = dot(d, d);
    if (squared >= least) continue;
    least = squared;
    place = {triangle, share};
  }
  return place.triangle >= 0;
}

Vec3f BodySurface::at(const SkinPlace& place, bool at_end) const {
  const auto& t = triangles_[static_cast<std::size_t>(place.triangle)];
  const auto& p = at_end ? end_ : begin_;
  return p[static_cast<std::size_t>(t[0])] * place.share[0] + p[static_cast<std::size_t>(t[1])] * place.share[1] +
         p[static_cast<std::size_t>(t[2])] * place.share[2];
}

Vec3f BodySurface::facing(const SkinPlace& place, bool at_end) const {
  const auto& t = triangles_[static_cast<std::size_t>(place.triangle)];
  const auto& n = at_end ? end_normal_ : begin_normal_;
  return normalized(n[static_cast<std::size_t>(t[0])] * place.share[0] +
                    n[static_cast<std::size_t>(t[1])] * place.share[1] +
                    n[static_cast<std::size_t>(t[2])] * place.share[2]);
}

Vec3f BodySurface::along(const SkinPlace& place, bool at_end) const {
  const auto& t = triangles_[static_cast<std::size_t>(place.triangle)];
  const auto& p = at_end ? end_ : begin_;
  const Vec3f n = facing(place, at_end);
  const Vec3f edge = p[static_cast<std::size_t>(t[1])] - p[static_cast<std::size_t>(t[0])];
  return normalized(edge - n * dot(edge, n));
}

}  // namespace im2fit::body
