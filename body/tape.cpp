// SPDX-License-Identifier: Apache-2.0
#include "body/tape.h"

#include <cmath>
#include <limits>

#include "body/contour.h"
#include "body/model_data.h"
#include "body/skeleton.h"

namespace im2fit::body {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr float kMiddleMm = 0.01F;  // off the middle of the mean body, which is symmetric
// A search walks its way in 16 steps, then looks about the best one in eighths of a step: 3 mm along a thigh's 400.
constexpr int kSearchSteps = 16;
constexpr int kSearchFine = 8;
using Side = PointRef::Side;

struct Value {
  Vec3f p;
  bool known = false;
};

Side side_of(PointRef ref, Side own) {
  return ref.side == Side::own ? own : ref.side;
}

}  // namespace

int point_index(const Tape& tape, std::string_view id) {
  for (std::size_t i = 0; i < tape.points.size(); ++i)
    if (tape.points[i].id == id) return static_cast<int>(i);
  return -1;
}

int definition_index(const Tape& tape, std::string_view id) {
  for (std::size_t i = 0; i < tape.definitions.size(); ++i)
    if (tape.definitions[i].id == id) return static_cast<int>(i);
  return -1;
}

std::string_view unit_of(const TapeDefinition& definition) {
  return definition.kind == TapeKind::value ? kMeasurementTable[measurement_index(definition.value)].unit : "mm";
}

std::string_view name_of(TapeKind kind) {
  constexpr std::array<std::string_view, 10> kNames = {"value",   "height", "breadth", "depth", "girth",
                                                       "contour", "arc",    "length",  "sum",   "refused"};
  return kNames[static_cast<std::size_t>(kind)];
}
std::string_view name_of(TapePlane plane) {
  constexpr std::array<std::string_view, 6> kNames = {"level", "line", "points", "sagittal", "upright", "facing"};
  return kNames[static_cast<std::size_t>(plane)];
}
std::string_view name_of(TapeSide side) {
  constexpr std::array<std::string_view, 4> kNames = {"middle", "left", "right", "mean"};
  return kNames[static_cast<std::size_t>(side)];
}
std::string_view name_of(TapeSearch search) {
  constexpr std::array<std::string_view, 3> kNames = {"none", "smallest", "largest"};
  return kNames[static_cast<std::size_t>(search)];
}

class TapeMeasurer::Work {
 public:
  explicit Work(const BodyModel& model) : model_(model), measurer_(model) {
    const auto triangles = model.body_triangles();
    for (std::size_t i = 0; i < triangles.size(); ++i)
      if (model.data().triangle_is_arm[i] == 0) armless_.push_back(triangles[i]);
    find_middle_line();
  }

  void measure(const Tape& tape, const Params& params, std::span<float> out) {
    measurer_.measure(params);
    measure(tape, measurer_, out);
  }
  void measure_rest_mesh(const Tape& tape, std::span<const Vec3f> rest_vertices, float gender, std::span<float> out) {
    measurer_.measure_rest_mesh(rest_vertices, gender);
    measure(tape, measurer_, out);
  }
  void measure(const Tape& tape, const Measurer& measured, std::span<float> out) {
    take(measured);
    place_points(tape);
    for (std::size_t i = 0; i < tape.definitions.size(); ++i) {
      const TapeDefinition& d = tape.definitions[i];
      switch (d.side) {
        case TapeSide::mean:
          out[i] = 0.5F * (measure_one(d, Side::left, out, nullptr) + measure_one(d, Side::right, out, nullptr));
          break;
        case TapeSide::right:
          out[i] = measure_one(d, Side::right, out, nullptr);
          break;
        case TapeSide::left:
        case TapeSide::middle:
          out[i] = measure_one(d, Side::left, out, nullptr);
      }
    }
  }

  TapeLines lines(const Tape& tape, int index) {
    TapeLines all;
    place_points(tape);
    add_lines(tape, index, all);
    return all;
  }
  std::span<const Vec3f> mesh() const { return posed_; }

 private:
  void take(const Measurer& measured) {
    values_ = measured.values();
    posed_ = measured.posed();
    bones_ = measured.bones();
    sections_ = measured.sections();
    all_blocks_.place(model_.body_triangles(), body());
    armless_blocks_.place(armless_, body());
    floor_ = posed_[0].y;
    for (const Vec3f& v : body()) floor_ = v.y < floor_ ? v.y : floor_;
    for (std::size_t i = 0; i < middle_line_.size(); ++i)
      middle_points_[i] = posed_[static_cast<std::size_t>(middle_line_[i])];
  }
  // Round the body in its middle: vertices that lie there in the mean body, in order along the mesh's edges, whose
  // line closes. It stays in the middle however uneven a person is, where a plane would cut into a thigh.
  void find_middle_line() {
    const std::span<const Vec3f> base = model_.data().base;
    const auto in_middle = [&](std::int32_t v) { return std::fabs(base[static_cast<std::size_t>(v)].x) < kMiddleMm; };
    std::vector<std::array<std::int32_t, 2>> next(base.size(), {-1, -1});
    for (const Triangle& t : model_.body_triangles())
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t from = t[k], to = t[(k + 1) % 3];
        if (!in_middle(from) || !in_middle(to)) continue;
        auto& of = next[static_cast<std::size_t>(from)];
        if (of[0] != to && of[1] != to) of[of[0] < 0 ? 0 : 1] = to;
      }
    const std::int32_t start = model_.data().landmark(Landmark::crotch);
    bool closed = false;
    for (std::int32_t v = start, before = -1; v >= 0 && !closed && middle_line_.size() < base.size();) {
      middle_line_.push_back(v);
      const auto& of = next[static_cast<std::size_t>(v)];
      const std::int32_t after = of[0] != before ? of[0] : of[1];
      before = v;
      v = after;
      closed = v == start;
    }
    if (!closed) middle_line_.clear();  // no body of ours: lengths in its middle are not known
    middle_points_.resize(middle_line_.size());
  }
  std::span<const Vec3f> body() const { return posed_.first(static_cast<std::size_t>(model_.body_vertex_count())); }

  void place_points(const Tape& tape) {
    places_.assign(2 * tape.points.size(), {});
    for (std::size_t i = 0; i < tape.points.size(); ++i)
      for (const Side side : {Side::left, Side::right})
        places_[2 * i + (side == Side::right ? 1 : 0)] = place(tape.points[i], side);
  }

  Value at(PointRef ref, Side own) const {
    const Side side = side_of(ref, own);
    return places_[2 * static_cast<std::size_t>(ref.point) + (side == Side::right ? 1 : 0)];
  }

  Value place(const TapePoint& point, Side side) const {
    const std::size_t pick = point.paired && side == Side::right ? 1 : 0;
    switch (point.kind) {
      case TapePoint::Kind::vertex:
        return {posed_[static_cast<std::size_t>(point.vertex[pick])], true};
      case TapePoint::Kind::bone: {
        const auto s = static_cast<std::size_t>(point.segment[pick]);
        return {point.tail ? bones_.tail[s] : bones_.head[s], true};
      }
      case TapePoint::Kind::level:
        return level_middle(point.level);
      case TapePoint::Kind::between: {
        const Value a = at(point.a, side), b = at(point.b, side);
        return {a.p + (b.p - a.p) * point.share, a.known && b.known};
      }
      case TapePoint::Kind::at: {
        const Value a = at(point.a, side), b = at(point.b, side);
        return {{a.p.x, b.p.y, a.p.z}, a.known && b.known};
      }
      case TapePoint::Kind::moved: {
        const Value a = at(point.a, side);
        const float x = point.paired && side == Side::right ? -point.by.x : point.by.x;
        return {a.p + Vec3f{x, point.by.y, point.by.z}, a.known};
      }
      case TapePoint::Kind::skin:
        break;
    }
    const Value a = at(point.a, side);
    return a.known ? leave_skin(a.p, point.toward, side) : a;
  }

  Value level_middle(Measurement level) const {
    for (const Section& section : sections_) {
      if (section.id != level || section.hull.size() < 3) continue;
      // The middle of the section's extent: the hull's points crowd where the mesh is fine.
      Vec3f low = section.hull[0], high = low;
      for (const Vec3f& p : section.hull) {
        low = {p.x < low.x ? p.x : low.x, p.y < low.y ? p.y : low.y, p.z < low.z ? p.z : low.z};
        high = {p.x > high.x ? p.x : high.x, p.y > high.y ? p.y : high.y, p.z > high.z ? p.z : high.z};
      }
      return {(low + high) * 0.5F, true};
    }
    return {};
  }

  // Where a ray leaves the skin for good. Arms hang beside the trunk and do not count.
  Value leave_skin(Vec3f p, TapePoint::Toward toward, Side side) const {
    using Toward = TapePoint::Toward;
    const bool sideways = toward == Toward::outside;
    const float sign = toward == Toward::back || (sideways && side == Side::right) ? -1.0F : 1.0F;
    // Across the ray: u and height; along it: w.
    const auto u_of = [&](const Vec3f& v) { return sideways ? v.z : v.x; };
    const auto w_of = [&](const Vec3f& v) { return sideways ? v.x : v.z; };
    const float u = u_of(p);
    float best = 0;
    bool known = false;
    armless_blocks_.at_height(p.y, [&](std::size_t, std::span<const Triangle> triangles) {
      for (const Triangle& t : triangles) {
        const Vec3f a = posed_[static_cast<std::size_t>(t[0])], b = posed_[static_cast<std::size_t>(t[1])],
                    c = posed_[static_cast<std::size_t>(t[2])];
        const auto edge = [&](const Vec3f& from, const Vec3f& to) {
          return (u_of(to) - u_of(from)) * (p.y - from.y) - (to.y - from.y) * (u - u_of(from));
        };
        const float ab = edge(a, b), bc = edge(b, c), ca = edge(c, a), area = ab + bc + ca;
        if (!((ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0)) || area == 0) continue;
        const float w = (bc * w_of(a) + ca * w_of(b) + ab * w_of(c)) / area;
        if (known && !(sign * w > sign * best)) continue;
        best = w;
        known = true;
      }
    });
    return {sideways ? Vec3f{best, p.y, p.z} : Vec3f{p.x, p.y, best}, known};
  }

  float measure_one(const TapeDefinition& d, Side side, std::span<const float> before, TapeLines* lines) {
    if (d.kind == TapeKind::value) return values_[measurement_index(d.value)];
    if (d.kind == TapeKind::refused) return kNone;
    if (d.kind == TapeKind::sum) {
      float sum = 0;
      for (const TapeTerm& term : d.terms) sum += term.factor * before[static_cast<std::size_t>(term.definition)];
      return sum;
    }
    std::array<Vec3f, kTapePointsMax> at_points{};
    if (!find_points(d, side, at_points)) return kNone;
    const std::span<const Vec3f> p = std::span(at_points).first(d.points.size());
    switch (d.kind) {
      case TapeKind::height:
        return height(p, lines);
      case TapeKind::length:
        if (lines != nullptr) lines->emplace_back(p.begin(), p.end());
        return static_cast<float>(path_mm(p));
      case TapeKind::arc:
        return arc(d, p, lines);
      default:
        break;
    }
    std::array<Vec3f, kTapePointsMax> at_other{};
    const bool limb = d.side != TapeSide::middle && d.plane != TapePlane::points &&
                      find_points(d, side == Side::left ? Side::right : Side::left, at_other);
    return section(d, p, limb ? std::span(at_other).first(p.size()) : std::span<const Vec3f>(), lines);
  }

  bool find_points(const TapeDefinition& d, Side side, std::array<Vec3f, kTapePointsMax>& out) const {
    for (std::size_t i = 0; i < d.points.size(); ++i) {
      const Value v = at(d.points[i], side);
      if (!v.known) return false;
      out[i] = v.p;
    }
    return true;
  }

  float height(std::span<const Vec3f> p, TapeLines* lines) const {
    const float low = p.size() > 1 ? p[1].y : floor_;
    if (lines != nullptr) lines->push_back({p[0], {p[0].x, low, p[0].z}});
    return p[0].y - low;
  }

  // Sections.

  static SectionPlane plane_of(const TapeDefinition& d, std::span<const Vec3f> p, float share) {
    const Vec3f way = p.size() > 1 && d.plane != TapePlane::points ? p[1] - p[0] : Vec3f{};
    const Vec3f at = p[0] + way * share;
    if (d.plane == TapePlane::line) return plane_through(at, way);
    if (d.plane == TapePlane::points)
      return plane_through((p[0] + p[1] + p[2]) * (1.0F / 3), cross(p[1] - p[0], p[2] - p[0]));
    SectionPlane level = level_plane(at.y);
    level.origin = at;
    return level;
  }

  float size_of(TapeKind kind, std::span<const Vec3f> loop, const SectionPlane& plane, TapeLines* lines) {
    if (loop.size() < 3) return kNone;
    if (kind == TapeKind::breadth || kind == TapeKind::depth) return extent(kind, loop, lines);
    std::span<const Vec3f> round = loop;
    if (kind == TapeKind::girth) {
      hulls_.convex_hull(loop, plane, hull_);
      round = hull_;
    }
    if (lines != nullptr) {
      lines->emplace_back(round.begin(), round.end());
      lines->back().push_back(round[0]);
    }
    return static_cast<float>(perimeter_mm(round));
  }

  static float extent(TapeKind kind, std::span<const Vec3f> loop, TapeLines* lines) {
    const auto along = [&](const Vec3f& p) { return kind == TapeKind::breadth ? p.x : p.z; };
    const Vec3f* low = loop.data();
    const Vec3f* high = low;
    for (const Vec3f& p : loop) {
      if (along(p) < along(*low)) low = &p;
      if (along(p) > along(*high)) high = &p;
    }
    if (lines != nullptr) lines->push_back({*low, *high});
    return along(*high) - along(*low);
  }

  // At the chest arms may be one piece with the trunk: a tape round the trunk excludes the arms.
  static bool round_trunk(const TapeDefinition& d) {
    return d.side == TapeSide::middle && d.plane == TapePlane::level && d.kind != TapeKind::contour;
  }

  // `mesh`: blocks or a slab of the triangles that count. `share`: where between the points. A limb's tape goes round
  // no other limb: below the crotch flesh that hangs may still join the thighs, and high up an arm may join the
  // trunk.
  template <class Mesh>
  float size_at(const TapeDefinition& d, const Mesh& mesh, std::span<const Vec3f> p, std::span<const Vec3f> other,
                float share, TapeLines* lines) {
    const SectionPlane plane = plane_of(d, p, share);
    contours_.cut(mesh, plane);
    const std::span<const Vec3f> loop = round_trunk(d) ? contours_.points() : contours_.about(plane.origin);
    if (!other.empty() && goes_round(loop, plane, plane_of(d, other, share).origin)) return kNone;
    return size_of(d.kind, loop, plane, lines);
  }

  // `other`: a limb's points on the other side, else none.
  float section(const TapeDefinition& d, std::span<const Vec3f> p, std::span<const Vec3f> other, TapeLines* lines) {
    const TriangleBlocks& mesh = round_trunk(d) ? armless_blocks_ : all_blocks_;
    if (d.search == TapeSearch::none) return size_at(d, mesh, p, other, d.share, lines);
    slab_.gather(mesh, plane_of(d, p, d.search_from), plane_of(d, p, d.search_to));
    const float step = (d.search_to - d.search_from) / kSearchSteps;
    float best_share = d.search_from, best = kNone;
    const auto look = [&](float share) {
      if (share < d.search_from || share > d.search_to) return;
      const float size = size_at(d, slab_, p, other, share, nullptr);
      const bool better = d.search == TapeSearch::largest ? size > best : size < best;
      if (!better && (std::isnan(size) || !std::isnan(best))) return;
      best = size;
      best_share = share;
    };
    for (int i = 0; i <= kSearchSteps; ++i) look(d.search_from + step * static_cast<float>(i));
    const float coarse = best_share;
    for (int i = 1 - kSearchFine; i < kSearchFine; ++i)
      if (i != 0) look(coarse + step * static_cast<float>(i) / kSearchFine);
    return lines == nullptr ? best : size_at(d, slab_, p, other, best_share, lines);
  }

  // Arcs.

  float arc(const TapeDefinition& d, std::span<const Vec3f> p, TapeLines* lines) {
    const Vec3f chord = p[2] - p[0];
    Vec3f normal = {0, 1, 0};
    if (d.plane == TapePlane::points) normal = cross(p[1] - p[0], chord);
    if (d.plane == TapePlane::sagittal) normal = {1, 0, 0};
    if (d.plane == TapePlane::upright) normal = cross(chord, {0, 1, 0});
    if (d.plane == TapePlane::facing) normal = cross(chord, {0, 0, 1});
    if (norm(normal) == 0) return kNone;
    const SectionPlane plane = plane_through(p[0], normal);
    std::span<const Vec3f> line = middle_points_;
    if (d.plane != TapePlane::sagittal) {
      contours_.cut(all_blocks_, plane);
      line = contours_.through(p[0], p[2]);
    }
    taut_path(line, plane, p[0], p[1], p[2], path_);
    if (path_.size() < 2) return kNone;
    if (lines != nullptr) lines->push_back(path_);
    return static_cast<float>(path_mm(path_));
  }

  void add_lines(const Tape& tape, int index, TapeLines& all) {
    const TapeDefinition& d = tape.definitions[static_cast<std::size_t>(index)];
    if (d.kind == TapeKind::sum) {
      for (const TapeTerm& term : d.terms) add_lines(tape, term.definition, all);
    } else if (d.kind == TapeKind::value) {
      for (const Section& section : sections_) {
        if (section.id != d.value || section.hull.size() < 3) continue;
        all.push_back(section.hull);
        all.back().push_back(section.hull[0]);
      }
      if (all.empty()) add_value_line(d.value, all);
    } else {
      if (d.side != TapeSide::right) measure_one(d, Side::left, {}, &all);
      if (d.side == TapeSide::right || d.side == TapeSide::mean) measure_one(d, Side::right, {}, &all);
    }
  }

  // Lines of those of the eleven values that are not girths.
  void add_value_line(Measurement value, TapeLines& all) const {
    const auto head = [&](Segment s) { return bones_.head[static_cast<std::size_t>(s)]; };
    const auto mark = [&](Landmark l) { return posed_[static_cast<std::size_t>(model_.data().landmark(l))]; };
    if (value == Measurement::stature) {
      Vec3f top = posed_[0];
      for (const Vec3f& v : body()) top = v.y > top.y ? v : top;
      all.push_back({top, {top.x, floor_, top.z}});
    } else if (value == Measurement::inside_leg) {
      const Vec3f crotch = mark(Landmark::crotch);
      all.push_back({crotch, {crotch.x, floor_, crotch.z}});
    } else if (value == Measurement::shoulder_breadth) {
      all.push_back({mark(Landmark::left_acromion), mark(Landmark::right_acromion)});
    } else if (value == Measurement::sleeve_length) {
      all.push_back({mark(Landmark::left_acromion), head(Segment::left_lower_arm), head(Segment::left_hand)});
      all.push_back({mark(Landmark::right_acromion), head(Segment::right_lower_arm), head(Segment::right_hand)});
    } else if (value == Measurement::leg_length) {
      all.push_back({head(Segment::left_upper_leg), head(Segment::left_lower_leg), head(Segment::left_foot)});
      all.push_back({head(Segment::right_upper_leg), head(Segment::right_lower_leg), head(Segment::right_foot)});
    }
  }

  const BodyModel& model_;
  Measurer measurer_;
  std::vector<Triangle> armless_;
  std::vector<std::int32_t> middle_line_;
  std::vector<Vec3f> middle_points_;
  std::span<const Vec3f> posed_;
  MeasurementValues values_{};
  PosedSkeleton bones_;
  std::span<const Section> sections_;
  float floor_ = 0;
  std::vector<Value> places_;  // left and right of each point
  TriangleBlocks all_blocks_, armless_blocks_;
  TriangleSlab slab_;
  Contours contours_;
  HullWork hulls_;
  std::vector<Vec3f> hull_, path_;
};

TapeMeasurer::TapeMeasurer(const BodyModel& model) : work_(std::make_unique<Work>(model)) {}
TapeMeasurer::TapeMeasurer(TapeMeasurer&&) noexcept = default;
TapeMeasurer& TapeMeasurer::operator=(TapeMeasurer&&) noexcept = default;
TapeMeasurer::~TapeMeasurer() = default;

void TapeMeasurer::measure(const Tape& tape, const Params& params, std::span<float> out) {
  work_->measure(tape, params, out);
}
void TapeMeasurer::measure_rest_mesh(const Tape& tape, std::span<const Vec3f> rest_vertices, float gender,
                                     std::span<float> out) {
  work_->measure_rest_mesh(tape, rest_vertices, gender, out);
}
void TapeMeasurer::measure(const Tape& tape, const Measurer& body, std::span<float> out) {
  work_->measure(tape, body, out);
}
TapeLines TapeMeasurer::lines(const Tape& tape, int definition) {
  return work_->lines(tape, definition);
}
std::span<const Vec3f> TapeMeasurer::mesh() const {
  return work_->mesh();
}

}  // namespace im2fit::body
