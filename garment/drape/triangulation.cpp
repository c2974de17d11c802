// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/triangulation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace im2fit::body {
namespace {

struct Place {
  double x, y;
};

// An outline's edges by the bands of height they reach into: a place is tested against its band's edges alone.
class Outline {
 public:
  Outline(const std::vector<Flat>& places, double band_mm) : band_mm_(band_mm), low_(places[0].y) {
    double high = low_;
    for (const Flat& f : places) {
      low_ = std::min<double>(low_, f.y);
      high = std::max<double>(high, f.y);
    }
    bands_.resize(static_cast<std::size_t>((high - low_) / band_mm_) + 1);
    for (std::size_t i = 0, j = places.size() - 1; i < places.size(); j = i++) {
      const Edge edge = {places[i].x, places[i].y, places[j].x, places[j].y};
      for (std::size_t b = band(std::min(edge.ay, edge.by)); b <= band(std::max(edge.ay, edge.by)); ++b)
        bands_[b].push_back(edge);
    }
  }
  bool holds(double x, double y) const {
    bool in = false;
    for (const Edge& e : bands_[band(y)])
      if ((e.ay > y) != (e.by > y) && x < (e.bx - e.ax) * (y - e.ay) / (e.by - e.ay) + e.ax) in = !in;
    return in;
  }

 private:
  struct Edge {
    double ax, ay, bx, by;
  };
  std::size_t band(double y) const {
    return std::min(bands_.size() - 1, static_cast<std::size_t>(std::max(0.0, (y - low_) / band_mm_)));
  }
  double band_mm_, low_;
  std::vector<std::vector<Edge>> bands_;
};

double squared_distance_to(Flat a, Flat b, double x, double y) {
  const double dx = static_cast<double>(b.x) - a.x, dy = static_cast<double>(b.y) - a.y;
  const double along = ((x - a.x) * dx + (y - a.y) * dy) / (dx * dx + dy * dy + 1e-12);
  const double t = std::clamp(along, 0.0, 1.0);
  const double ox = a.x + t * dx - x, oy = a.y + t * dy - y;
  return ox * ox + oy * oy;
}

// A triangle with its circumscribed circle.
struct Circled {
  std::array<int, 3> corner;
  double x, y, squared_radius;
};

Circled circled(const std::vector<Place>& p, int a, int b, int c) {
  const auto at = [&](int i) { return p[static_cast<std::size_t>(i)]; };
  const double bx = at(b).x - at(a).x, by = at(b).y - at(a).y;
  const double cx = at(c).x - at(a).x, cy = at(c).y - at(a).y;
  double d = 2 * (bx * cy - by * cx);
  if (std::fabs(d) < 1e-9) d = 1e-9;
  const double ux = (cy * (bx * bx + by * by) - by * (cx * cx + cy * cy)) / d;
  const double uy = (bx * (cx * cx + cy * cy) - cx * (bx * bx + by * by)) / d;
  return {{a, b, c}, at(a).x + ux, at(a).y + uy, ux * ux + uy * uy};
}

// Triangles whose circles a later point may touch. Those taken out leave a circle that no point touches, and are
// swept out together.
class OpenTriangles {
 public:
  void add(const Circled& t) {
    if (end_ == corner_.size()) grow();
    x_[end_] = t.x;
    y_[end_] = t.y;
    squared_radius_[end_] = t.squared_radius;
    corner_[end_++] = t.corner;
  }
  // Takes out all whose circle lies left of the point, and all whose circle holds it; calls one of the two with each,
  // oldest first.
  template <class Left, class Held>
  void take(Place at, Left left, Held held) {
    for (std::size_t first = 0; first < end_; first += kLanes) {
      if (!touches(at, first)) continue;
      for (std::size_t i = first; i < first + kLanes; ++i) {
        const double dx = at.x - x_[i], dy = at.y - y_[i];
        if (dx > 0 && dx * dx > squared_radius_[i])
          left(corner_[i]);
        else if (dx * dx + dy * dy < squared_radius_[i])
          held(corner_[i]);
        else
          continue;
        close(i);
        ++closed_;
      }
    }
    if (closed_ > end_ / 4) sweep();
  }
  template <class F>
  void each(F f) const {
    for (std::size_t i = 0; i < end_; ++i)
      if (x_[i] < kClosed) f(corner_[i]);
  }

 private:
  static constexpr std::size_t kLanes = 4;
  static constexpr double kClosed = 1e200;  // its square is infinite
  using Two = double __attribute__((vector_size(16)));
  [[gnu::always_inline]] static Two load(const double* from) {
    Two two;
    std::memcpy(&two, from, sizeof two);
    return two;
  }
  // Inlined even where the file is compiled for size: this is nearly all the work.
  [[gnu::always_inline]] bool touches(Place at, std::size_t first) const {
    const Two x = {at.x, at.x}, y = {at.y, at.y};
    const double *xs = x_.data() + first, *ys = y_.data() + first, *radii = squared_radius_.data() + first;
    const Two dx = x - load(xs), dx_next = x - load(xs + 2);
    const Two dy = y - load(ys), dy_next = y - load(ys + 2);
    const Two across = dx * dx, across_next = dx_next * dx_next;
    const Two radius = load(radii), radius_next = load(radii + 2);
    const auto any =
        (((dx > Two{}) & (across > radius)) | (across + dy * dy < radius)) |
        (((dx_next > Two{}) & (across_next > radius_next)) | (across_next + dy_next * dy_next < radius_next));
    return (any[0] | any[1]) != 0;
  }
  void close(std::size_t i) {
    x_[i] = kClosed;
    squared_radius_[i] = -1;
  }
  void grow() {
    for (std::vector<double>* list : {&x_, &y_, &squared_radius_}) list->resize(end_ + kLanes);
    corner_.resize(end_ + kLanes);
    for (std::size_t i = end_; i < end_ + kLanes; ++i) close(i);
  }
  void sweep() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < end_; ++i) {
      if (x_[i] >= kClosed) continue;
      x_[kept] = x_[i];
      y_[kept] = y_[i];
      squared_radius_[kept] = squared_radius_[i];
      corner_[kept++] = corner_[i];
    }
    for (std::size_t i = kept; i < end_; ++i) close(i);
    end_ = kept;
    closed_ = 0;
  }
  std::vector<double> x_, y_, squared_radius_;  // of whole kLanes
  std::vector<std::array<int, 3>> corner_;
  std::size_t end_ = 0, closed_ = 0;
};

// Points are inserted from left to right, so a triangle whose circle lies left of the next point is final.
std::vector<std::array<int, 3>> delaunay(const std::vector<Place>& points) {
  std::vector<Place> p = points;
  const int count = static_cast<int>(points.size());
  constexpr double kFar = 1e5;  // mm: the triangle about everything
  p.push_back({-kFar, -kFar});
  p.push_back({kFar, -kFar});
  p.push_back({0, kFar});
  std::vector<int> order(points.size());
  for (int i = 0; i < count; ++i) order[static_cast<std::size_t>(i)] = i;
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const Place &l = p[static_cast<std::size_t>(a)], &r = p[static_cast<std::size_t>(b)];
    return l.x != r.x ? l.x < r.x : l.y < r.y;
  });
  std::vector<std::array<int, 3>> out;
  const auto keep = [&](const std::array<int, 3>& corner) {
    if (corner[0] < count && corner[1] < count && corner[2] < count) out.push_back(corner);
  };
  OpenTriangles open;
  open.add(circled(p, count, count + 1, count + 2));
  std::vector<std::pair<int, int>> rim;  // directed edges of the hole that no second triangle has
  for (const int i : order) {
    rim.clear();
    open.take(p[static_cast<std::size_t>(i)], keep, [&](const std::array<int, 3>& corner) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::pair<int, int> edge = {corner[k], corner[(k + 1) % 3]};
        const auto other = std::find(rim.begin(), rim.end(), std::pair{edge.second, edge.first});
        if (other == rim.end()) {
          rim.push_back(edge);
        } else {
          *other = rim.back();
          rim.pop_back();
        }
      }
    });
    std::sort(rim.begin(), rim.end());
    for (const auto& [from, to] : rim) open.add(circled(p, from, to, i));
  }
  open.each(keep);
  return out;
}

// -1..1 by number: points of a lattice lie on common circles, and which diagonal is taken should not be left to
// chance.
double shift_of(std::uint32_t number) {
  number = (number ^ 61U) ^ (number >> 16U);
  number *= 0x27D4EB2DU;
  number ^= number >> 15U;
  return static_cast<double>(number & 0xFFFFU) / 32768.0 - 1.0;
}

std::vector<Place> lattice(const std::vector<Flat>& outline, double edge) {
  double left = outline[0].x, right = left, low = outline[0].y, high = low;
  for (const Flat& f : outline) {
    left = std::min<double>(left, f.x);
    right = std::max<double>(right, f.x);
    low = std::min<double>(low, f.y);
    high = std::max<double>(high, f.y);
  }
  constexpr double kRowShare = 0.8660254037844386;  // sqrt(3) / 2
  constexpr double kClear = 0.6;                    // of an edge, between lattice and outline: no slivers
  constexpr double kShiftMm = 1e-4;
  std::vector<Place> out;
  std::uint32_t number = 0;
  const int rows = static_cast<int>((high - low) / (edge * kRowShare)) + 1;
  const int columns = static_cast<int>((right - left) / edge) + 2;
  std::vector<double> crossings;                            // of the outline with a row
  std::vector<std::pair<std::size_t, std::size_t>> beside;  // its edges that come near a row
  for (int r = 0; r < rows; ++r) {
    const double y = low + (r + 0.5) * edge * kRowShare;
    crossings.clear();
    beside.clear();
    for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const double ax = outline[i].x, ay = outline[i].y, bx = outline[j].x, by = outline[j].y;
      if ((ay > y) != (by > y)) crossings.push_back((bx - ax) * (y - ay) / (by - ay) + ax);
      if (std::min(ay, by) < y + kClear * edge && std::max(ay, by) > y - kClear * edge) beside.push_back({i, j});
    }
    for (int c = 0; c < columns; ++c) {
      const double x = left + (c + ((r & 1) != 0 ? 0.5 : 0.0)) * edge;
      const auto right_of = std::count_if(crossings.begin(), crossings.end(), [&](double at) { return x < at; });
      if ((right_of & 1) == 0) continue;
      double nearest = 1e30;
      for (const auto& [i, j] : beside)
        nearest = std::min(nearest, squared_distance_to(outline[i], outline[j], x, y));
      if (nearest < kClear * kClear * edge * edge) continue;
      out.push_back({x + kShiftMm * shift_of(++number), y + kShiftMm * shift_of(++number)});
    }
  }
  return out;
}

}  // namespace

FilledPanel fill_panel(const std::vector<Flat>& outline, float edge_mm) {
  std::vector<Place> points;
  points.reserve(outline.size());
  for (const Flat& f : outline) points.push_back({f.x, f.y});
  const auto inner = lattice(outline, edge_mm);
  points.insert(points.end(), inner.begin(), inner.end());
  FilledPanel panel;
  for (const Place& p : points) panel.points.push_back({static_cast<float>(p.x), static_cast<float>(p.y)});
  const Outline border(outline, static_cast<double>(edge_mm));
  for (const auto& t : delaunay(points)) {
    const auto at = [&](std::size_t k) { return points[static_cast<std::size_t>(t[k])]; };
    const Place a = at(0), b = at(1), c = at(2);
    if (!border.holds((a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3)) continue;
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (std::fabs(area) < 0.1) continue;  // mm²: along a straight outline
    if (area > 0)
      panel.triangles.push_back({t[0], t[1], t[2]});
    else
      panel.triangles.push_back({t[0], t[2], t[1]});
  }
  return panel;
}

}  // namespace im2fit::body
