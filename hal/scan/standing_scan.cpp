// SPDX-License-Identifier: Apache-2.0
#include "hal/scan/standing_scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

namespace im2fit::hal {
namespace {

constexpr std::size_t kPointsMin = 500;
constexpr float kHeightMinMm = 1200, kHeightMaxMm = 2300;
// Points beyond these shares are dust.
constexpr double kLowShare = 0.001, kHighShare = 0.999;

constexpr float kAboutMaxMm = 1500;
constexpr double kBoxesMaxMm2 = 2e8;       // of a body some 1e7
constexpr float kUprightCosine = 0.9976F;  // of 4 degrees
constexpr int kUprightRounds = 3;

struct Unit {
  const char* name;
  double mm;
};
// Each takes heights that no other does.
constexpr Unit kUnits[] = {{"metres", 1000}, {"feet", 304.8},     {"decimetres", 100},
                           {"inches", 25.4}, {"centimetres", 10}, {"millimetres", 1}};

struct Range {
  float low = 0, high = 0;
  float size() const { return high - low; }
};

// Of what `coordinate` gives of the points: between the shares, or nothing for none.
template <class F>
Range range_of(const std::vector<Vec3f>& points, F coordinate, double low = kLowShare, double high = kHighShare) {
  std::vector<float> values;
  values.reserve(points.size());
  for (const Vec3f p : points) values.push_back(coordinate(p));
  if (values.empty()) return {};
  const auto at = [&](double share) {
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  const float bottom = at(low);
  return {bottom, at(high)};
}

std::vector<Vec3f> slab(const std::vector<Vec3f>& points, float low_y, float high_y) {
  std::vector<Vec3f> out;
  for (const Vec3f p : points)
    if (p.y >= low_y && p.y < high_y) out.push_back(p);
  return out;
}

struct Flat {
  double x = 0, z = 0;
};
Flat middle_of(const std::vector<Vec3f>& points) {
  Flat sum;
  for (const Vec3f p : points) {
    sum.x += static_cast<double>(p.x);
    sum.z += static_cast<double>(p.z);
  }
  const double n = std::max<double>(1, static_cast<double>(points.size()));
  return {sum.x / n, sum.z / n};
}

// Root mean square distance from their middle, seen from above.
double spread_of(const std::vector<Vec3f>& points) {
  const Flat middle = middle_of(points);
  double sum = 0;
  for (const Vec3f p : points) {
    const double x = static_cast<double>(p.x) - middle.x, z = static_cast<double>(p.z) - middle.z;
    sum += x * x + z * z;
  }
  return points.empty() ? 0 : std::sqrt(sum / static_cast<double>(points.size()));
}

// The six ways an axis can point up; each keeps right-handed axes right-handed.
struct Up {
  const char* name;
  Vec3f (*turned)(Vec3f);
};
constexpr std::size_t kAxes = 3;  // of kUps: the ways up first, then down in the same order
constexpr Up kUps[] = {
    {"y", [](Vec3f p) { return p; }},
    {"z",
     [](Vec3f p) {
       return Vec3f{p.x, p.z, -p.y};
     }},
    {"x",
     [](Vec3f p) {
       return Vec3f{-p.y, p.x, p.z};
     }},
    {"-y",
     [](Vec3f p) {
       return Vec3f{p.x, -p.y, -p.z};
     }},
    {"-z",
     [](Vec3f p) {
       return Vec3f{p.x, -p.z, p.y};
     }},
    {"-x",
     [](Vec3f p) {
       return Vec3f{p.y, -p.x, p.z};
     }},
};

float height_along(const Up& up, const std::vector<Vec3f>& points) {
  return range_of(points, [&](Vec3f p) { return up.turned(p).y; }).size();
}

// A floor that was scanned, too: many points in one low slab, further out than feet stand. Its height; none: no
// floor.
std::optional<float> floor_in(const std::vector<Vec3f>& points, float height) {
  const Range y = range_of(
      points, [](Vec3f p) { return p.y; }, 0.0005, 0.9995);
  const std::vector<Vec3f> low = slab(points, y.low, y.low + 0.015F * height);
  if (static_cast<double>(low.size()) < 0.04 * static_cast<double>(points.size())) return std::nullopt;
  const float wide = range_of(low, [](Vec3f p) { return p.x; }).size();
  const float deep = range_of(low, [](Vec3f p) { return p.z; }).size();
  if (wide < 0.45F * height || deep < 0.35F * height) return std::nullopt;
  return range_of(
             low, [](Vec3f p) { return p.y; }, 0.05, 0.5)
      .high;
}

// Points for which `keep` is true, and the triangles of these.
template <class F>
void keep_points(std::vector<Vec3f>& points, std::vector<ScanTriangle>& triangles, F keep) {
  constexpr std::uint32_t kGone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> place(points.size(), kGone);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!keep(points[i])) continue;
    place[i] = static_cast<std::uint32_t>(kept);
    points[kept++] = points[i];
  }
  points.resize(kept);
  std::size_t whole = 0;
  for (const ScanTriangle& t : triangles) {
    const ScanTriangle moved = {place[t[0]], place[t[1]], place[t[2]]};
    if (moved[0] != kGone && moved[1] != kGone && moved[2] != kGone) triangles[whole++] = moved;
  }
  triangles.resize(whole);
}

std::vector<Vec3f> turned_up(const Up& up, const std::vector<Vec3f>& points) {
  std::vector<Vec3f> out;
  out.reserve(points.size());
  for (const Vec3f p : points) out.push_back(up.turned(p));
  return out;
}

// Away from a floor that was scanned; else along the longest axis. Feet reach further than the crown of a head: the
// positive end is up unless the other is plainly the smaller one.
const Up& find_up(const std::vector<Vec3f>& points) {
  std::array<float, kAxes> heights{};
  for (std::size_t i = 0; i < kAxes; ++i) heights[i] = height_along(kUps[i], points);
  const float largest = *std::max_element(heights.begin(), heights.end());
  for (std::size_t i = 0; i < std::size(kUps); ++i) {
    // A person who stands on a floor of 2.5 m is no lower than this beside it.
    const float height = heights[i % kAxes];
    if (height > 0.5F * largest && floor_in(turned_up(kUps[i], points), height)) return kUps[i];
  }
  std::size_t axis = 0;
  // Arms stretched out are as long as a person is tall: y and z point up in nearly all files.
  for (std::size_t i = 1; i < kAxes; ++i)
    if (heights[i] > heights[axis] * 1.05F) axis = i;
  const std::vector<Vec3f> turned = turned_up(kUps[axis], points);
  const Range y = range_of(turned, [](Vec3f p) { return p.y; });
  const auto spread_between = [&](float low, float high) {
    return spread_of(slab(turned, y.low + low * y.size(), y.low + high * y.size()));
  };
  const double low = spread_between(0.004F, 0.025F), high = spread_between(0.975F, 0.996F);
  return low > 0 && low < 0.75 * high ? kUps[axis + kAxes] : kUps[axis];
}

// From the middle of the feet to that of the head: of people who stand it leans by less than two degrees.
Vec3f feet_to_head(const std::vector<Vec3f>& points) {
  const Range y = range_of(points, [](Vec3f p) { return p.y; });
  const Flat feet = middle_of(slab(points, y.low - 0.01F * y.size(), y.low + 0.05F * y.size()));
  const Flat head = middle_of(slab(points, y.high - 0.1F * y.size(), y.high + 0.01F * y.size()));
  return normalized(Vec3f{static_cast<float>(head.x - feet.x), 0.9F * y.size(), static_cast<float>(head.z - feet.z)});
}

// What lies about the person: further aside from their middle than they are tall, or beyond half of that above and
// below.
void leave_out_dust(std::vector<Vec3f>& points, std::vector<ScanTriangle>& triangles) {
  const Range y = range_of(points, [](Vec3f p) { return p.y; });
  const float x = range_of(
                      points, [](Vec3f p) { return p.x; }, 0.5, 0.5)
                      .low;
  const float z = range_of(
                      points, [](Vec3f p) { return p.z; }, 0.5, 0.5)
                      .low;
  keep_points(points, triangles, [&](Vec3f p) {
    return std::fabs(p.x - x) < y.size() && std::fabs(p.z - z) < y.size() && p.y > y.low - 0.5F * y.size() &&
           p.y < y.high + 0.5F * y.size();
  });
}

// The smallest turn that takes `from`, a unit vector with y > 0, to +y.
void set_upright(std::vector<Vec3f>& points, Vec3f from) {
  const float per = 1 / (1 + from.y);
  for (Vec3f& p : points) {
    const float aside = from.x * p.x + from.z * p.z;
    p = {p.x - from.x * (aside * per + p.y), from.y * p.y + aside, p.z - from.z * (aside * per + p.y)};
  }
}

// Turns about the y axis so that `forward` becomes +z.
void face(std::vector<Vec3f>& points, Flat forward) {
  const double size = std::hypot(forward.x, forward.z);
  const auto s = static_cast<float>(forward.x / size), c = static_cast<float>(forward.z / size);
  for (Vec3f& p : points) p = {c * p.x - s * p.z, p.y, s * p.x + c * p.z};
}

// Where the toes point; none: feet cannot be told.
std::optional<Flat> toes_of(const std::vector<Vec3f>& points) {
  const Flat feet = middle_of(slab(points, 0, 50)), ankles = middle_of(slab(points, 100, 160));
  const Flat out = {feet.x - ankles.x, feet.z - ankles.z};
  if (std::hypot(out.x, out.z) < 12) return std::nullopt;
  return out;
}

// Square to the longer side of the trunk, on the side of +z; none: it is round.
std::optional<Flat> square_to_trunk(const std::vector<Vec3f>& points, float height) {
  const std::vector<Vec3f> trunk = slab(points, 0.56F * height, 0.8F * height);
  const Flat middle = middle_of(trunk);
  double xx = 0, xz = 0, zz = 0;
  for (const Vec3f p : trunk) {
    const double x = static_cast<double>(p.x) - middle.x, z = static_cast<double>(p.z) - middle.z;
    xx += x * x;
    xz += x * z;
    zz += z * z;
  }
  const double angle = 0.5 * std::atan2(2 * xz, xx - zz);  // of the longer side, from +x
  const Flat along = {std::cos(angle), std::sin(angle)};
  Flat out = {-along.z, along.x};
  if (out.z < 0) out = {-out.x, -out.z};
  const double apart = std::hypot(xx - zz, 2 * xz);
  if (apart < 0.25 * (xx + zz)) return std::nullopt;
  return out;
}

// Faces the other way round where most of the surface looks inwards.
void turn_outwards(const std::vector<Vec3f>& points, std::vector<ScanTriangle>& triangles) {
  double six_volumes = 0;
  for (const ScanTriangle& t : triangles)
    six_volumes += static_cast<double>(dot(points[t[0]], cross(points[t[1]], points[t[2]])));
  if (six_volumes < 0)
    for (ScanTriangle& t : triangles) std::swap(t[1], t[2]);
}

// Squares about all triangles: what a picture of them costs.
double boxes_mm2(const StandingScan& scan) {
  double sum = 0;
  for (const ScanTriangle& t : scan.triangles) {
    float longest = 0;
    for (std::size_t i = 0; i < 3; ++i)
      longest = std::max(longest, norm(scan.points[t[i]] - scan.points[t[(i + 1) % 3]]));
    sum += static_cast<double>(longest) * static_cast<double>(longest);
  }
  return sum;
}

Error too_few(std::size_t count, const std::string& what) {
  return {ErrorCode::corrupt, what + ": it has " + std::to_string(count) + " points of a person, too few (" +
                                  std::to_string(kPointsMin) + ")"};
}

std::string shortly(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

}  // namespace

Result<StandingScan> stand_scan(Scan scan, const ScanOptions& options, const std::string& what) {
  if (scan.points.size() < kPointsMin) return too_few(scan.points.size(), what);
  const Up* up = nullptr;
  for (const Up& known : kUps)
    if (options.up == known.name) up = &known;
  if (up == nullptr && !options.up.empty())
    return Error{ErrorCode::invalid_argument,
                 "up is \"" + options.up + "\", expected x, -x, y, -y, z or -z: an axis of the scan"};
  StandingScan out;
  if (up == nullptr) up = &find_up(scan.points);
  out.up = up->name;
  out.points = std::move(scan.points);
  out.triangles = std::move(scan.triangles);
  for (Vec3f& p : out.points) p = up->turned(p);

  leave_out_dust(out.points, out.triangles);
  for (int round = 0; round < kUprightRounds; ++round) {
    const Vec3f along = feet_to_head(out.points);
    if (along.y > kUprightCosine) break;
    set_upright(out.points, along);
    out.straightened = true;
  }
  float height = range_of(out.points, [](Vec3f p) { return p.y; }).size();
  if (const auto floor = floor_in(out.points, height)) {
    const float above = *floor + 0.006F * height;
    keep_points(out.points, out.triangles, [&](Vec3f p) { return p.y > above; });
    if (out.points.size() < kPointsMin) return Error{ErrorCode::corrupt, what + ": it is a floor without a person"};
    // The soles stay on it.
    for (Vec3f& p : out.points) p.y -= *floor;
    height = range_of(out.points, [](Vec3f p) { return p.y; }).high;
  } else {
    const float low = range_of(out.points, [](Vec3f p) { return p.y; }).low;
    for (Vec3f& p : out.points) p.y -= low;
  }

  out.unit_mm = options.unit_mm;
  if (out.unit_mm == 0)
    for (const Unit& unit : kUnits)
      if (const double mm = static_cast<double>(height) * unit.mm;
          mm >= static_cast<double>(kHeightMinMm) && mm <= static_cast<double>(kHeightMaxMm))
        out.unit_mm = unit.mm;
  if (out.unit_mm == 0)
    return Error{ErrorCode::invalid_argument,
                 what + ": it is " + shortly(static_cast<double>(height)) + " units tall along its " + up->name +
                     " axis, and by no unit a standing person of 1.2 to 2.3 m; give --unit (millimetres a unit) or "
                     "--up"};
  const auto mm = static_cast<float>(out.unit_mm);
  for (Vec3f& p : out.points) p = p * mm;
  out.height_mm = height * mm;
  if (!(out.height_mm >= kHeightMinMm && out.height_mm <= kHeightMaxMm))
    return Error{ErrorCode::invalid_argument, what + ": with this unit it is " +
                                                  shortly(static_cast<double>(out.height_mm)) +
                                                  " mm tall, expected a standing person of 1200 to 2300"};
  const Flat middle = middle_of(slab(out.points, 0.45F * out.height_mm, 0.6F * out.height_mm));
  for (Vec3f& p : out.points) p = {p.x - static_cast<float>(middle.x), p.y, p.z - static_cast<float>(middle.z)};
  if (const auto toes = toes_of(out.points)) face(out.points, *toes);
  if (const auto square = square_to_trunk(out.points, out.height_mm)) {
    // Feet that point aside by more than this belong to a trunk that is turned.
    constexpr double kAsideMin = 0.75;  // cosine
    if (square->z > kAsideMin) face(out.points, *square);
  }
  // The camera stands 2.4 m away.
  keep_points(out.points, out.triangles, [](Vec3f p) { return std::hypot(p.x, p.z) < kAboutMaxMm; });
  if (out.points.size() < kPointsMin) return too_few(out.points.size(), what);
  if (boxes_mm2(out) > kBoxesMaxMm2)
    return Error{ErrorCode::corrupt, what + ": its triangles lie over one another many times; export it again"};
  turn_outwards(out.points, out.triangles);
  return out;
}

}  // namespace im2fit::hal
