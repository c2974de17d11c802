// SPDX-License-Identifier: Apache-2.0
#include "garment/pattern.h"

#include <algorithm>
#include <cmath>

namespace im2fit::body {

const std::array<std::string_view, kCutMeasureCount> kCutMeasureNames = {
    "chest",        "waist",   "high_hip",      "hip",
    "thigh",        "knee",    "calf",          "upper_arm",
    "wrist",        "neck",    "shoulder",      "arm",
    "inside_leg",   "stature", "shoulder_x",    "shoulder_to_neck",
    "shoulder_top", "hip_x",   "hip_to_crotch", "hip_to_high_hip"};

CutBody cut_body(const CutRegression& regression, bool woman, float chest_mm) {
  CutBody body{};
  for (std::size_t i = 0; i < kCutMeasureCount; ++i) {
    const CutRegression::Line& line = regression.lines[woman ? 1 : 0][i];
    body[i] = line.mm + line.per_chest * chest_mm;
  }
  body[static_cast<std::size_t>(CutMeasure::chest)] = chest_mm;
  return body;
}

CutBody turned_up(CutBody body, float inside_leg_mm) {
  float& leg = body[static_cast<std::size_t>(CutMeasure::inside_leg)];
  leg = inside_leg_mm < leg ? inside_leg_mm : leg;
  return body;
}

namespace {

constexpr int kCurveSteps = 64;  // of a Bezier curve before it is spaced evenly

// Every length and point of a pattern in one size.
struct Numbers {
  CutBody body;
  std::vector<float> lengths;
  std::vector<Flat> front, back;

  float value(const LinearForm& form) const {
    float sum = form.mm;
    for (const LinearForm::Term& term : form.terms) {
      const auto i = static_cast<std::size_t>(term.index);
      const float of = term.of == LinearForm::Of::measure   ? body[i]
                       : term.of == LinearForm::Of::length  ? lengths[i]
                       : term.of == LinearForm::Of::point_x ? front[i].x
                                                            : front[i].y;
      sum += term.factor * of;
    }
    return sum;
  }
};

Numbers numbers_of(const GarmentPattern& pattern, const CutBody& body) {
  Numbers n{body, {}, {}, {}};
  // Lengths may use points and points lengths: a length is worth 0 until the points it names stand, so the reader
  // takes lengths of measures and lengths only.
  for (const LinearForm& form : pattern.lengths) n.lengths.push_back(n.value(form));
  for (const PatternPoint& p : pattern.points) {
    const Flat front = {n.value(p.x), n.value(p.y)};
    const Flat back = p.has_back ? Flat{n.value(p.back_x), n.value(p.back_y)} : front;
    n.front.push_back(front);
    n.back.push_back(back);
  }
  return n;
}

float distance(Flat a, Flat b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

Flat mixed(Flat a, Flat b, float share) {
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)};
}

std::vector<Flat> curve(const std::vector<Flat>& control) {
  if (control.size() == 2) return control;
  std::vector<Flat> out;
  for (int i = 0; i <= kCurveSteps; ++i) {
    std::vector<Flat> level = control;  // de Casteljau
    const float share = static_cast<float>(i) / kCurveSteps;
    for (std::size_t left = level.size() - 1; left > 0; --left)
      for (std::size_t k = 0; k < left; ++k) level[k] = mixed(level[k], level[k + 1], share);
    out.push_back(level[0]);
  }
  return out;
}

float length_of(const std::vector<Flat>& line) {
  float sum = 0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += distance(line[i - 1], line[i]);
  return sum;
}

// `count` even steps along a line.
std::vector<Flat> spaced(const std::vector<Flat>& line, int count) {
  const float step = length_of(line) / static_cast<float>(count);
  std::vector<Flat> out = {line.front()};
  std::size_t at = 1;
  float passed = 0;
  for (int i = 1; i < count; ++i) {
    const float want = step * static_cast<float>(i);
    while (at + 1 < line.size() && passed + distance(line[at - 1], line[at]) < want) {
      passed += distance(line[at - 1], line[at]);
      ++at;
    }
    const float piece = distance(line[at - 1], line[at]);
    out.push_back(mixed(line[at - 1], line[at], piece > 0 ? (want - passed) / piece : 0));
  }
  out.push_back(line.back());
  return out;
}

constexpr float kCheckedEdgeMm = 12;  // as cloth is sewn: garment/drape/garment_mesh.h

std::vector<Flat> outline_of(const CutPattern& cut, bool back) {
  std::vector<Flat> outline;
  for (const CutPattern::Line& line : cut.lines)
    for (std::size_t i = 0; i + 1 < line.front.size() || i + 1 < line.back.size(); ++i) {
      const std::vector<Flat>& places = back ? line.back : line.front;
      if (i + 1 < places.size()) outline.push_back(places[i]);
    }
  // A fold closes it; of a leg the last line has come back to the first point.
  const CutPattern::Line& last = cut.lines.back();
  const Flat end = back ? last.back.back() : last.front.back();
  if (distance(end, outline.front()) > 1e-3F) outline.push_back(end);
  return outline;
}

// Twice the signed area of the triangle.
double turn(Flat a, Flat b, Flat c) {
  return (static_cast<double>(b.x) - a.x) * (static_cast<double>(c.y) - a.y) -
         (static_cast<double>(b.y) - a.y) * (static_cast<double>(c.x) - a.x);
}

// Of two pieces of the outline that have no end in common; touching is no crossing.
bool cross(Flat a, Flat b, Flat c, Flat d) {
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

bool crosses_itself(const std::vector<Flat>& outline) {
  const std::size_t count = outline.size();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = i + 2; k < count; ++k)
      if ((k + 1) % count != i && cross(outline[i], outline[i + 1], outline[k], outline[(k + 1) % count]))
        return true;
  return false;
}

double area_mm2(const std::vector<Flat>& outline) {
  double twice = 0;
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) twice += turn(outline[0], outline[i], outline[i + 1]);
  return twice / 2;
}

int steps_for(const std::vector<Flat>& line, float edge_mm) {
  return std::max(1, static_cast<int>(std::ceil(length_of(line) / edge_mm)));
}

}  // namespace

CutPattern cut(const GarmentPattern& pattern, const CutBody& body, float edge_mm) {
  const Numbers n = numbers_of(pattern, body);
  CutPattern out;
  int from = pattern.start;
  for (const PatternEdge& edge : pattern.edges) {
    std::vector<int> places = {from};
    places.insert(places.end(), edge.via.begin(), edge.via.end());
    places.push_back(edge.to);
    std::vector<Flat> front, back;
    for (const int place : places) {
      front.push_back(n.front[static_cast<std::size_t>(place)]);
      back.push_back(n.back[static_cast<std::size_t>(place)]);
    }
    CutPattern::Line line;
    line.kind = edge.kind;
    front = curve(front);
    back = curve(back);
    line.front = spaced(front, steps_for(front, edge_mm));
    line.back = edge.kind == EdgeKind::seam ? line.front : spaced(back, steps_for(back, edge_mm));
    out.lines.push_back(std::move(line));
    from = edge.to;
  }
  if (pattern.gusset.at >= 0) out.gusset_at = n.front[static_cast<std::size_t>(pattern.gusset.at)];
  for (const FitRegion& region : pattern.regions) out.girth_mm.push_back(n.value(region.girth));
  return out;
}

Status check_cut(const GarmentPattern& pattern, const CutBody& body) {
  const auto refused = [&](const std::string& why) {
    return Error{ErrorCode::invalid_argument, "garment " + pattern.id + ": " + why};
  };
  const Numbers n = numbers_of(pattern, body);
  for (std::size_t i = 0; i < pattern.points.size(); ++i)
    for (const Flat& place : {n.front[i], n.back[i]})
      // Also false for what is not a number.
      if (!(std::fabs(place.x) <= kPatternMaxMm && std::fabs(place.y) <= kPatternMaxMm))
        return refused("point " + pattern.points[i].id + " lies more than " +
                       std::to_string(static_cast<int>(kPatternMaxMm)) + " mm from the middle");
  if (pattern.edges.empty()) return refused("it has no outline");
  const CutPattern flat = cut(pattern, body, kCheckedEdgeMm);
  double cloth_mm2 = 0;
  for (const bool back : {false, true}) {
    const std::string panel = back ? "the back" : "the front";
    const std::vector<Flat> outline = outline_of(flat, back);
    if (static_cast<float>(outline.size()) * kCheckedEdgeMm > kOutlineMaxMm)  // first: crossings take its square
      return refused("the outline of " + panel + " is longer than " +
                     std::to_string(static_cast<int>(kOutlineMaxMm) / 1000) + " m");
    if (outline.size() < 3 || crosses_itself(outline)) return refused("the outline of " + panel + " crosses itself");
    const double area = area_mm2(outline);
    if (area <= 0) return refused("the outline of " + panel + " is not drawn anticlockwise");
    cloth_mm2 += 2 * area;  // left and right
  }
  if (cloth_mm2 > 1e6 * static_cast<double>(kClothMaxM2))
    return refused("it has " + std::to_string(std::lround(cloth_mm2 / 1e6)) + " m2 of cloth, expected at most " +
                   std::to_string(std::lround(kClothMaxM2)));
  return Ok{};
}

std::vector<float> finished_girths(const GarmentPattern& pattern, const CutBody& body) {
  const Numbers n = numbers_of(pattern, body);
  std::vector<float> out;
  for (const FitRegion& region : pattern.regions) out.push_back(n.value(region.girth));
  return out;
}

}  // namespace im2fit::body
