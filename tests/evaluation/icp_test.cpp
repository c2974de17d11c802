// SPDX-License-Identifier: Apache-2.0
// ICP recovers a motion it was not given, and measures distances that are known.
#include "evaluation/measurements/icp.h"

#include <gtest/gtest.h>

#include <cmath>

namespace im2fit::lab {
namespace {

struct Mesh {
  std::vector<Vec3f> vertices;
  std::vector<body::Triangle> triangles;
};

// Three different half axes: no motion but none maps it onto itself.
Mesh ellipsoid(float a, float b, float c) {
  constexpr int kRings = 40, kSides = 60;
  Mesh mesh;
  for (int i = 0; i <= kRings; ++i)
    for (int k = 0; k < kSides; ++k) {
      const double polar = 3.14159265358979 * i / kRings, round = 2 * 3.14159265358979 * k / kSides;
      mesh.vertices.push_back({a * static_cast<float>(std::sin(polar) * std::cos(round)),
                               b * static_cast<float>(std::cos(polar)),
                               c * static_cast<float>(std::sin(polar) * std::sin(round))});
    }
  for (int i = 0; i < kRings; ++i)
    for (int k = 0; k < kSides; ++k) {
      const int p = i * kSides + k, q = i * kSides + (k + 1) % kSides;
      mesh.triangles.push_back({p, q, q + kSides});
      mesh.triangles.push_back({p, q + kSides, p + kSides});
    }
  return mesh;
}

Mesh square() {
  return {{{0, 0, 0}, {100, 0, 0}, {100, 100, 0}, {0, 100, 0}, {1e6F, 1e6F, 1e6F}}, {{0, 1, 2}, {0, 2, 3}}};
}

TEST(MeshSurface, FindsClosestPoints) {
  const Mesh mesh = square();
  const MeshSurface surface(mesh.vertices, mesh.triangles);
  struct Case {
    Eigen::Vector3d from, foot;
  };
  for (const auto& [from, foot] : {Case{{30, 40, 7}, {30, 40, 0}}, Case{{-3, 50, 4}, {0, 50, 0}},
                                   Case{{130, 140, 0}, {100, 100, 0}}, Case{{70, 20, -9}, {70, 20, 0}}}) {
    const MeshSurface::Foot found = surface.closest(from);
    EXPECT_NEAR((found.point - foot).norm(), 0, 1e-9);
    EXPECT_NEAR(found.distance_mm, (from - foot).norm(), 1e-9);
    EXPECT_NEAR(std::abs(found.normal.z()), 1, 1e-12);
  }
}

TEST(MeanDistance, IsKnownAboveASquare) {
  const Mesh mesh = square();
  const MeshSurface surface(mesh.vertices, mesh.triangles);
  const Cloud cloud = {{10, 10, 2}, {20, 80, -4}, {103, 50, 0}};
  EXPECT_NEAR(mean_distance_mm(surface, cloud, Eigen::Isometry3d::Identity()), 3, 1e-9);
}

TEST(Icp, FindsAKnownMotionAgain) {
  const Mesh mesh = ellipsoid(250, 800, 150);
  const MeshSurface surface(mesh.vertices, mesh.triangles);
  Eigen::Isometry3d away = Eigen::Isometry3d::Identity();
  away.translate(Eigen::Vector3d(15, -20, 12));
  away.rotate(Eigen::AngleAxisd(0.08, Eigen::Vector3d(1, 2, -1).normalized()));
  // Half of it, as a camera sees a person.
  Cloud cloud;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    const Vec3f v = mesh.vertices[i];
    if (v.z > 0) cloud.push_back(away * Eigen::Vector3d(v.x, v.y, v.z));
  }
  const IcpTrace trace = register_cloud(surface, cloud, 15, 1000);
  ASSERT_EQ(trace.error_mm.size(), 16U);
  EXPECT_GT(trace.error_mm.front(), 10);
  EXPECT_LT(trace.error_mm.back(), 0.01);
  const Eigen::Isometry3d left = trace.motion * away;
  EXPECT_LT(left.translation().norm(), 0.05);
  EXPECT_LT(Eigen::AngleAxisd(left.linear()).angle(), 1e-4);
}

TEST(Icp, FarPairsPullNothing) {
  const Mesh mesh = ellipsoid(250, 800, 150);
  const MeshSurface surface(mesh.vertices, mesh.triangles);
  Cloud cloud;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 2) {
    const Vec3f v = mesh.vertices[i];
    cloud.push_back({v.x + 5.0, v.y, v.z});
  }
  for (int i = 0; i < 100; ++i) cloud.push_back({900.0 + i, 0, 0});
  const IcpTrace held = register_cloud(surface, cloud, 15, 150);
  EXPECT_NEAR(held.motion.translation().x(), -5, 0.05);
  // They are in the error all the same.
  EXPECT_GT(held.error_mm.back(), 20);
}

}  // namespace
}  // namespace im2fit::lab
