// SPDX-License-Identifier: Apache-2.0
// Tapes round and along simple shapes whose lengths are known.
#include "body/contour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace im2fit::body {
namespace {

struct Mesh {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
  TriangleBlocks blocks() const {
    TriangleBlocks all;
    all.place(triangles, vertices);
    return all;
  }
};

// A closed surface of revolution about an upright axis at (x, 0, z), from the outline's radii, outward.
void add_turned(Mesh& m, float x, float z, const std::vector<std::pair<float, float>>& radius_and_height, int sides) {
  const auto first = static_cast<std::int32_t>(m.vertices.size());
  for (const auto& [r, y] : radius_and_height)
    for (int i = 0; i < sides; ++i) {
      const double t = 2 * std::numbers::pi * i / sides;
      m.vertices.push_back({x + r * static_cast<float>(std::cos(t)), y, z + r * static_cast<float>(std::sin(t))});
    }
  for (std::int32_t row = 0; row + 1 < static_cast<std::int32_t>(radius_and_height.size()); ++row)
    for (std::int32_t i = 0; i < sides; ++i) {
      const std::int32_t j = (i + 1) % sides, a = first + row * sides + i, b = first + row * sides + j;
      m.triangles.push_back({a, a + sides, b + sides});
      m.triangles.push_back({a, b + sides, b});
    }
}
std::vector<std::pair<float, float>> sphere(float radius, int rows) {
  std::vector<std::pair<float, float>> outline;
  for (int i = 0; i <= rows; ++i) {
    const double t = std::numbers::pi * i / rows;
    outline.emplace_back(radius * static_cast<float>(std::sin(t)), -radius * static_cast<float>(std::cos(t)));
  }
  return outline;
}

TEST(Contours, ACylindersGirth) {
  Mesh m;
  add_turned(m, 0, 0, {{100, -500}, {100, 500}}, 720);
  Contours contours;
  contours.cut(m.blocks(), level_plane(37));
  ASSERT_EQ(contours.count(), 1U);
  EXPECT_NEAR(perimeter_mm(contours.loop(0)), 2 * std::numbers::pi * 100, 0.02);
  // Across at 45 degrees: an ellipse of 100 and 100 sqrt 2.
  const SectionPlane slanted = plane_through({0, 0, 0}, {0, 1, 1});
  contours.cut(m.blocks(), slanted);
  ASSERT_EQ(contours.count(), 1U);
  EXPECT_NEAR(perimeter_mm(contours.loop(0)), 764.04, 0.05);
  contours.cut(m.blocks(), level_plane(600));
  EXPECT_EQ(contours.count(), 0U);
  EXPECT_TRUE(contours.about({}).empty());
}

// In blocks as triangle by triangle: planes that touch a vertex, that miss all, and askew.
TEST(Contours, BlocksLeaveNoCrossingOut) {
  Mesh m;
  add_turned(m, 0, 0, sphere(200, 40), 60);
  const TriangleBlocks blocks = m.blocks();
  TriangleSlab slab;
  Contours contours, sliced;
  std::size_t crossed = 0;
  for (const Vec3f normal : {Vec3f{0, 1, 0}, Vec3f{0.3F, 1, 0.1F}, Vec3f{1, 0, 0}, Vec3f{-1, 0.5F, 2}})
    for (float y = -210; y <= 210; y += 5) {
      const SectionPlane plane = plane_through({0, y, 0}, normal);
      contours.cut(blocks, plane);
      std::size_t want = 0;
      for (const Triangle& t : m.triangles) {
        int above = 0;
        for (const std::int32_t corner : t)
          above += dot(m.vertices[static_cast<std::size_t>(corner)], plane.normal) > dot(plane.origin, plane.normal);
        want += above == 1 || above == 2;
      }
      ASSERT_EQ(contours.points().size(), want) << y;
      crossed += want;
      // A slab that begins or ends there gives the same lines.
      slab.gather(blocks, plane, plane_through({0, y - std::copysign(60.0F, y), 0}, normal));
      sliced.cut(slab, plane);
      ASSERT_EQ(sliced.count(), contours.count()) << y;
      ASSERT_EQ(sliced.points().size(), contours.points().size()) << y;
      for (std::size_t i = 0; i < want; ++i) {
        ASSERT_EQ(sliced.points()[i].x, contours.points()[i].x) << y;
        ASSERT_EQ(sliced.points()[i].y, contours.points()[i].y) << y;
        ASSERT_EQ(sliced.points()[i].z, contours.points()[i].z) << y;
      }
    }
  EXPECT_GT(crossed, 10000U);
}

TEST(TriangleBlocks, ABlockIsVisitedOnceAndInOrder) {
  Mesh m;
  add_turned(m, 0, 0, sphere(200, 40), 60);
  const TriangleBlocks blocks = m.blocks();
  std::size_t next = 0, visited = 0;
  blocks.at_height(30, [&](std::size_t first, std::span<const Triangle> triangles) {
    EXPECT_GE(first, next);
    EXPECT_EQ(triangles.data(), m.triangles.data() + first);
    next = first + triangles.size();
    visited += triangles.size();
  });
  EXPECT_LT(visited, m.triangles.size() / 4);
  std::size_t all = 0;
  for (float y = -200; y <= 200; y += 1)
    blocks.at_height(y, [&](std::size_t, std::span<const Triangle> triangles) { all += triangles.size(); });
  EXPECT_GE(all, m.triangles.size());
}

TEST(Contours, OfSeveralTheOneAboutThePoint) {
  Mesh m;
  add_turned(m, 0, 0, {{100, -500}, {100, 500}}, 90);
  add_turned(m, 250, 0, {{40, -500}, {40, 500}}, 90);
  Contours contours;
  contours.cut(m.blocks(), level_plane(3));
  ASSERT_EQ(contours.count(), 2U);
  EXPECT_NEAR(perimeter_mm(contours.about({10, 3, 20})), 2 * std::numbers::pi * 100, 0.5);
  EXPECT_NEAR(perimeter_mm(contours.about({270, 3, 0})), 2 * std::numbers::pi * 40, 0.5);
  EXPECT_NEAR(perimeter_mm(contours.about({400, 3, 0})), 2 * std::numbers::pi * 40, 0.5)
      << "the nearest, beside both";
  EXPECT_NEAR(perimeter_mm(contours.through({210, 3, 0}, {290, 3, 0})), 2 * std::numbers::pi * 40, 0.5);
}

TEST(TautPath, ArcsOverASphere) {
  Mesh m;
  add_turned(m, 0, 0, sphere(200, 360), 360);
  Contours contours;
  std::vector<Vec3f> path;
  // From the equator in front over the pole to the equator behind, and the short way over an eighth.
  const SectionPlane plane = plane_through({0.3F, 0, 0}, {1, 0, 0});
  contours.cut(m.blocks(), plane);
  ASSERT_EQ(contours.count(), 1U);
  for (const float top : {200.0F, -200.0F}) {
    taut_path(contours.loop(0), plane, {0, 0, 200}, {0, top, 0}, {0, 0, -200}, path);
    EXPECT_NEAR(path_mm(path), std::numbers::pi * 200, 0.1);
    EXPECT_GT(path.front().z, 199);
    EXPECT_LT(path.back().z, -199);
  }
  const float s = 200 * std::sqrt(0.5F);
  taut_path(contours.loop(0), plane, {0, 0, 200}, {0, 50, 190}, {0, s, s}, path);
  EXPECT_NEAR(path_mm(path), std::numbers::pi * 50, 0.1);
  taut_path(contours.loop(0), plane, {0, 0, 200}, {0, -200, 0}, {0, s, s}, path);
  EXPECT_NEAR(path_mm(path), std::numbers::pi * 350, 0.1) << "the long way, which via asks for";
}

// A tube without ends, cut lengthwise: each line is whole, wherever it begins.
TEST(Contours, OpenSurfacesGiveWholeLines) {
  Mesh m;
  add_turned(m, 0, 0, {{100, -300}, {100, -100}, {100, 0}, {100, 100}, {100, 300}}, 180);
  Contours contours;
  contours.cut(m.blocks(), plane_through({0.2F, 0, 0}, {1, 0, 0}));
  ASSERT_EQ(contours.count(), 2U);
  for (const std::size_t i : {0U, 1U}) EXPECT_NEAR(path_mm(contours.loop(i)), 500, 100);
}

// An hourglass: the tape from rim to rim is straight, the skin is not.
TEST(TautPath, BridgesHollows) {
  Mesh m;
  add_turned(m, 0, 0, {{0, -300}, {100, -300}, {100, -200}, {60, 0}, {100, 200}, {100, 300}, {0, 300}}, 180);
  const SectionPlane plane = plane_through({0.2F, 0, 0}, {1, 0, 0});
  Contours contours;
  contours.cut(m.blocks(), plane);
  std::vector<Vec3f> path;
  ASSERT_EQ(contours.count(), 1U);
  for (const float z : {100.0F, -100.0F}) {
    taut_path(contours.loop(0), plane, {0, -250, z}, {0, 0, 0.6F * z}, {0, 250, z}, path);
    EXPECT_NEAR(path_mm(path), 500, 1);
  }
}

}  // namespace
}  // namespace im2fit::body
