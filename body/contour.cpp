// SPDX-License-Identifier: Apache-2.0
#include "body/contour.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace im2fit::body {
namespace {

std::uint64_t edge_key(std::int32_t a, std::int32_t b) {
  const auto low = static_cast<std::uint64_t>(a < b ? a : b);
  const auto high = static_cast<std::uint64_t>(a < b ? b : a);
  return low << 32U | high;
}

struct Flat {
  float u, v;
};
Flat flat(Vec3f p, const SectionPlane& plane) {
  const Vec3f d = p - plane.origin;
  return {dot(d, plane.u), dot(d, plane.v)};
}
double turn(Flat o, Flat a, Flat b) {
  return (static_cast<double>(a.u) - o.u) * (static_cast<double>(b.v) - o.v) -
         (static_cast<double>(a.v) - o.v) * (static_cast<double>(b.u) - o.u);
}

bool goes_round_flat(std::span<const Vec3f> loop, const SectionPlane& plane, Flat p) {
  bool inside = false;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Flat a = flat(loop[i], plane), b = flat(loop[i + 1 == loop.size() ? 0 : i + 1], plane);
    if ((a.v > p.v) == (b.v > p.v)) continue;
    if (p.u < a.u + (b.u - a.u) * ((p.v - a.v) / (b.v - a.v))) inside = !inside;
  }
  return inside;
}

Vec3f middle_of(std::span<const Vec3f> loop) {
  Vec3f sum;
  for (const Vec3f& p : loop) sum = sum + p;
  return sum * (1.0F / static_cast<float>(loop.size()));
}

// The point of a closed line nearest to p: on the side that begins at `index`.
struct Place {
  std::size_t index = 0;
  float share = 0;
  Vec3f point;
  float distance = 1e30F;
};
Place nearest_place(std::span<const Vec3f> loop, Vec3f p) {
  Place best;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3f a = loop[i], d = loop[i + 1 == loop.size() ? 0 : i + 1] - a;
    const float square = dot(d, d);
    const float along = square > 0 ? dot(p - a, d) / square : 0;
    const float share = along > 0 ? (along < 1 ? along : 1) : 0;
    const Vec3f at = a + d * share;
    if (const float distance = norm(p - at); distance < best.distance) best = {i, share, at, distance};
  }
  return best;
}

// How far along the line from `from` on, in its points: for order alone.
float steps_after(const Place& from, const Place& to, std::size_t count) {
  const float n = static_cast<float>(count);
  const float a = static_cast<float>(from.index) + from.share, b = static_cast<float>(to.index) + to.share;
  return b >= a ? b - a : b - a + n;
}

}  // namespace

void Contours::add_step(const Triangle& t, std::span<const Vec3f> vertices, float level) {
  const auto above = [&](std::size_t i) {
    return dot(vertices[static_cast<std::size_t>(t[i])], plane_.normal) - level;
  };
  const std::array<float, 3> d = {above(0), above(1), above(2)};
  if ((d[0] > 0) == (d[1] > 0) && (d[1] > 0) == (d[2] > 0)) return;
  // One edge goes down and one up; the neighbour passes them the other way round, and so lines follow one another.
  Step step{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = i == 2 ? 0 : i + 1;
    if ((d[i] > 0) == (d[j] > 0)) continue;
    if (d[i] > 0) {
      const Vec3f a = vertices[static_cast<std::size_t>(t[i])], b = vertices[static_cast<std::size_t>(t[j])];
      step.to_edge = edge_key(t[i], t[j]);
      step.point = a + (b - a) * (d[i] / (d[i] - d[j]));
    } else {
      step.from_edge = edge_key(t[i], t[j]);
    }
  }
  steps_.push_back(step);
}

void Contours::cut(const TriangleBlocks& mesh, const SectionPlane& plane) {
  plane_ = plane;
  const float level = dot(plane.origin, plane.normal);
  steps_.clear();
  mesh.at_plane(plane, [&](std::size_t, std::span<const Triangle> triangles) {
    for (const Triangle& t : triangles) add_step(t, mesh.vertices(), level);
  });
  join();
}

void Contours::cut(const TriangleSlab& slab, const SectionPlane& plane) {
  plane_ = plane;
  const float level = dot(plane.origin, plane.normal);
  steps_.clear();
  slab.at_level(level, [&](const Triangle& t) { add_step(t, slab.vertices(), level); });
  join();
}

// Steps to lines.
void Contours::join() {
  std::sort(steps_.begin(), steps_.end(), [](const Step& a, const Step& b) { return a.from_edge < b.from_edge; });
  // Where a mesh is open a line begins at a step that follows none.
  const std::size_t count = steps_.size();
  enum : std::uint8_t { first_of_line, follows, used };
  next_.assign(count, count);
  state_.assign(count, first_of_line);
  for (std::size_t i = 0; i < count; ++i) {
    const auto next = std::lower_bound(steps_.begin(), steps_.end(), steps_[i].to_edge,
                                       [](const Step& s, std::uint64_t key) { return s.from_edge < key; });
    if (next == steps_.end() || next->from_edge != steps_[i].to_edge) continue;
    next_[i] = static_cast<std::size_t>(next - steps_.begin());
    state_[next_[i]] = follows;
  }
  points_.clear();
  first_.assign(1, 0);
  for (const auto from : {first_of_line, follows})
    for (std::size_t start = 0; start < count; ++start) {
      if (state_[start] != from) continue;
      for (std::size_t at = start; at < count && state_[at] != used; at = next_[at]) {
        state_[at] = used;
        points_.push_back(steps_[at].point);
      }
      first_.push_back(points_.size());
    }
}

std::span<const Vec3f> Contours::loop(std::size_t i) const {
  return std::span(points_).subspan(first_[i], first_[i + 1] - first_[i]);
}

bool goes_round(std::span<const Vec3f> loop, const SectionPlane& plane, Vec3f point) {
  return goes_round_flat(loop, plane, flat(point, plane));
}

std::span<const Vec3f> Contours::about(Vec3f inside) const {
  const Flat p = flat(inside, plane_);
  std::span<const Vec3f> round, near;
  double shortest = 0;
  float nearest = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const std::span<const Vec3f> line = loop(i);
    if (line.size() < 3) continue;
    const float distance = norm(middle_of(line) - inside);
    if (near.empty() || distance < nearest) {
      near = line;
      nearest = distance;
    }
    if (!goes_round_flat(line, plane_, p)) continue;
    const double length = perimeter_mm(line);
    if (round.empty() || length < shortest) {
      round = line;
      shortest = length;
    }
  }
  return round.empty() ? near : round;
}

std::span<const Vec3f> Contours::through(Vec3f from, Vec3f to) const {
  std::span<const Vec3f> best;
  float least = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const std::span<const Vec3f> line = loop(i);
    if (line.size() < 3) continue;
    const float distance = nearest_place(line, from).distance + nearest_place(line, to).distance;
    if (!best.empty() && distance >= least) continue;
    best = line;
    least = distance;
  }
  return best;
}

void taut_path(std::span<const Vec3f> loop, const SectionPlane& plane, Vec3f from, Vec3f via, Vec3f to,
               std::vector<Vec3f>& out) {
  out.clear();
  if (loop.size() < 3) return;
  Place a = nearest_place(loop, from), b = nearest_place(loop, to);
  const Place middle = nearest_place(loop, via);
  const bool forward = steps_after(a, middle, loop.size()) <= steps_after(a, b, loop.size());
  if (!forward) std::swap(a, b);
  double twice_area = 0;
  const Flat origin = flat(loop[0], plane);
  for (std::size_t i = 1; i + 1 < loop.size(); ++i)
    twice_area += turn(origin, flat(loop[i], plane), flat(loop[i + 1], plane));
  const double side = twice_area >= 0 ? 1 : -1;
  // Where the line turns inwards the tape leaves it: the point before is dropped, as often as that is so.
  const auto add = [&](Vec3f p) {
    while (out.size() >= 2 &&
           side * turn(flat(out[out.size() - 2], plane), flat(out.back(), plane), flat(p, plane)) <= 0)
      out.pop_back();
    out.push_back(p);
  };
  add(a.point);
  const auto inner = static_cast<std::size_t>(steps_after(a, b, loop.size()) + a.share);
  for (std::size_t i = 1; i <= inner && i <= loop.size(); ++i) add(loop[(a.index + i) % loop.size()]);
  add(b.point);
  if (!forward) std::reverse(out.begin(), out.end());
}

double path_mm(std::span<const Vec3f> path) {
  double sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double x = static_cast<double>(path[i].x) - path[i - 1].x;
    const double y = static_cast<double>(path[i].y) - path[i - 1].y;
    const double z = static_cast<double>(path[i].z) - path[i - 1].z;
    sum += std::sqrt(x * x + y * y + z * z);
  }
  return sum;
}

}  // namespace im2fit::body
