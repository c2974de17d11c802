// SPDX-License-Identifier: Apache-2.0
#include "body/section.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/rng.h"

namespace im2fit::body {
namespace {

struct Mesh {
  std::vector<Vec3f> vertices;
  std::vector<std::array<std::int32_t, 4>> quads;
};

// A tube along y from -1 to 1 m whose outline is radius(angle) times (a, b), mm.
template <class Radius>
Mesh tube(double a, double b, int sides, Radius radius) {
  Mesh m;
  for (int i = 0; i < sides; ++i) {
    const double t = 2 * std::numbers::pi * i / sides;
    const double r = radius(t);
    for (const float y : {-1000.0F, 1000.0F})
      m.vertices.push_back({static_cast<float>(r * a * std::cos(t)), y, static_cast<float>(r * b * std::sin(t))});
  }
  for (int i = 0; i < sides; ++i) {
    const int j = (i + 1) % sides;
    m.quads.push_back({2 * i, 2 * j, 2 * j + 1, 2 * i + 1});
  }
  return m;
}

double girth(const Mesh& m, const SectionPlane& plane) {
  std::vector<float> heights;
  heights_along(m.vertices, plane.normal, heights);
  TriangleStack stack;
  for (const auto& q : m.quads) {
    stack.add({q[0], q[1], q[2]}, heights);
    stack.add({q[0], q[2], q[3]}, heights);
  }
  std::vector<Vec3f> points;
  stack.cut(m.vertices, heights, dot(plane.origin, plane.normal), points);
  return perimeter_mm(convex_hull(points, plane));
}

double girth_at(const Level& level) {
  return perimeter_mm(convex_hull(level.points, level_plane(level.height)));
}

// Ramanujan's second approximation; exact to 1e-9 at these shapes.
double ellipse_perimeter(double a, double b) {
  const double h = (a - b) * (a - b) / ((a + b) * (a + b));
  return std::numbers::pi * (a + b) * (1 + 3 * h / (10 + std::sqrt(4 - 3 * h)));
}

const auto kRound = [](double) { return 1.0; };

TEST(Section, GirthOfAnEllipseIsTheEllipsesPerimeter) {
  EXPECT_NEAR(girth(tube(180, 120, 2000, kRound), level_plane(130)), ellipse_perimeter(180, 120), 0.01);
  EXPECT_NEAR(girth(tube(60, 55, 2000, kRound), level_plane(-999)), ellipse_perimeter(60, 55), 0.01);
}

TEST(Section, GirthOfABoxIsTheBoxes) {
  const double side = std::sqrt(2.0);
  const Mesh box = tube(100 * side, 100 * side, 4, kRound);  // a square of side 200
  EXPECT_NEAR(girth(box, level_plane(0.5F)), 800, 1e-3);
}

TEST(Section, TapeSpansHollows) {
  // A four-pointed star: the tape goes from tip to tip.
  const Mesh star =
      tube(200, 200, 8, [](double t) { return std::fmod(t + 0.01, std::numbers::pi / 2) < 0.1 ? 1.0 : 0.3; });
  EXPECT_NEAR(girth(star, level_plane(0)), 4 * 200 * std::sqrt(2.0), 1e-2);
}

TEST(Section, SlantedPlaneCutsALongerEllipse) {
  const double tilt = 20 * std::numbers::pi / 180;
  const SectionPlane plane =
      plane_through({0, 50, 0}, {static_cast<float>(std::sin(tilt)), static_cast<float>(std::cos(tilt)), 0});
  EXPECT_NEAR(girth(tube(150, 150, 2000, kRound), plane), ellipse_perimeter(150 / std::cos(tilt), 150), 0.02);
}

TEST(Section, ManyLevelsAtOnceAreTheLevels) {
  const Mesh cone = [] {
    Mesh m = tube(150, 100, 400, kRound);
    for (Vec3f& p : m.vertices)
      if (p.y > 0) p = {0.5F * p.x, p.y, 0.5F * p.z};
    return m;
  }();
  std::vector<float> heights;
  heights_along(cone.vertices, {0, 1, 0}, heights);
  std::vector<Level> levels(kLevelsMax);
  for (std::size_t l = 0; l < levels.size(); ++l) levels[l].height = 120 * static_cast<float>(l) - 900;
  section_levels(cone.quads, {}, cone.vertices, heights, levels);
  for (const Level& level : levels) {
    const double share = 1 - 0.25 * (static_cast<double>(level.height) + 1000) / 1000;
    EXPECT_NEAR(girth_at(level), share * ellipse_perimeter(150, 100), 0.05) << level.height;
    EXPECT_NEAR(girth_at(level), girth(cone, level_plane(level.height)), 1e-3) << level.height;
  }
}

TEST(Section, SkippedTrianglesDoNotCountWhereTheyAreHeeded) {
  const Mesh m = tube(150, 100, 400, kRound);
  std::vector<std::uint8_t> skip;
  for (const auto& q : m.quads) skip.insert(skip.end(), 2, m.vertices[static_cast<std::size_t>(q[0])].x > 0 ? 1 : 0);
  std::vector<float> heights;
  heights_along(m.vertices, {0, 1, 0}, heights);
  std::vector<Level> levels = {{0, true, {}}, {0, false, {}}};
  section_levels(m.quads, skip, m.vertices, heights, levels);
  EXPECT_NEAR(girth_at(levels[0]), ellipse_perimeter(150, 100) / 2 + 200, 3);
  EXPECT_NEAR(girth_at(levels[1]), ellipse_perimeter(150, 100), 0.05);
}

// Cauchy: a convex curve's length is the integral of its width over half a turn.
TEST(ConvexHull, LengthMatchesCauchysFormulaOnRandomPoints) {
  Rng rng(7);
  for (int round = 0; round < 20; ++round) {
    std::vector<Vec3f> points;
    for (int i = 0; i < 40; ++i)
      points.push_back({static_cast<float>(rng.normal(0, 90)), 25, static_cast<float>(rng.normal(30, 60))});
    double expected = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double t = std::numbers::pi * (i + 0.5) / kSteps;
      double low = 1e9, high = -1e9;
      for (const Vec3f& p : points) {
        const double s = static_cast<double>(p.x) * std::cos(t) + static_cast<double>(p.z) * std::sin(t);
        low = std::min(low, s);
        high = std::max(high, s);
      }
      expected += (high - low) * std::numbers::pi / kSteps;
    }
    EXPECT_NEAR(perimeter_mm(convex_hull(points, level_plane(25))), expected, 1e-2);
  }
}

TEST(ConvexHull, DegenerateInputGivesNoHull) {
  const SectionPlane plane = level_plane(0);
  EXPECT_TRUE(convex_hull({}, plane).empty());
  EXPECT_EQ(convex_hull(std::vector<Vec3f>(9, Vec3f{1, 0, 2}), plane).size(), 1U);
  const std::vector<Vec3f> line = {{0, 0, 0}, {10, 0, 0}, {5, 0, 0}, {10, 0, 0}};
  EXPECT_NEAR(perimeter_mm(convex_hull(line, plane)), 20, 1e-6);
}

}  // namespace
}  // namespace im2fit::body
