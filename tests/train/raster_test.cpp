// SPDX-License-Identifier: Apache-2.0
// The rasteriser against ray casting: truth is the ray's intersection with the analytic solid.
#include "train/render/raster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/rng.h"
#include "train/camera/virtual_camera.h"
#include "train/render/room.h"

namespace im2fit::lab {
namespace {

struct Ray {
  double x, y;  // direction (x, y, 1)
};
Ray ray_through(const Intrinsics& k, double u, double v) {
  return {(u - static_cast<double>(k.cx)) / static_cast<double>(k.fx),
          (v - static_cast<double>(k.cy)) / static_cast<double>(k.fy)};
}

// Slabs: a box about `centre` in camera axes, turned about y.
struct Box {
  Vec3f centre, size;
  float yaw_deg = 0;
};
std::optional<double> hit(const Box& box, Ray ray) {
  const double a = static_cast<double>(box.yaw_deg) * std::acos(-1.0) / 180;
  const auto turned = [&](double x, double y, double z) {
    return std::array<double, 3>{std::cos(a) * x - std::sin(a) * z, y, std::sin(a) * x + std::cos(a) * z};
  };
  const auto direction = turned(ray.x, ray.y, 1);
  const auto origin = turned(-static_cast<double>(box.centre.x), -static_cast<double>(box.centre.y),
                             -static_cast<double>(box.centre.z));
  const std::array<double, 3> half = {static_cast<double>(box.size.x) / 2, static_cast<double>(box.size.y) / 2,
                                      static_cast<double>(box.size.z) / 2};
  double enter = -1e30, leave = 1e30;
  for (std::size_t i = 0; i < 3; ++i) {
    const double t0 = (-half[i] - origin[i]) / direction[i], t1 = (half[i] - origin[i]) / direction[i];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  if (enter > leave) return std::nullopt;
  return enter;  // the ray's z component is 1
}

const Intrinsics kCamera{64, 48, 60.0F, 58.0F, 31.2F, 23.7F};
constexpr std::array<std::uint8_t, 1> kLabel = {7};

TEST(Raster, BoxesMatchRayCasting) {
  Rng rng(1);
  int compared = 0;
  for (int round = 0; round < 60; ++round) {
    const auto draw = [&](double a, double b) { return static_cast<float>(rng.uniform(a, b)); };
    const Box box{{draw(-500, 500), draw(-400, 400), draw(1500, 3000)},
                  {draw(100, 900), draw(100, 900), draw(100, 900)},
                  draw(-80, 80)};
    WorldMesh mesh;
    add_box(mesh, box.centre, box.size, box.yaw_deg);
    CleanView view(kCamera.width, kCamera.height);
    MeshRaster raster;
    raster.draw(mesh.vertices, mesh.triangles, kLabel, true, kCamera, whole(64, 48), view);
    for (int v = 0; v < 48; ++v) {
      for (int u = 0; u < 64; ++u) {
        const auto z = hit(box, ray_through(kCamera, u, v));
        const float q = view.inverse_depth[view.at(u, v)];
        // A hundredth of a pixel from the outline the snapped vertices may decide otherwise.
        const bool near_outline = [&] {
          for (const double du : {-0.01, 0.01})
            for (const double dv : {-0.01, 0.01})
              if (hit(box, ray_through(kCamera, u + du, v + dv)).has_value() != z.has_value()) return true;
          return false;
        }();
        if (near_outline) continue;
        ASSERT_EQ(q > 0, z.has_value()) << "box " << round << " pixel " << u << "," << v;
        if (!z) continue;
        ++compared;
        // Snapping to 1/256 px moves a face by up to that much: bound by the depth's change over 1/100 px.
        double slack = 0.05;
        for (const double du : {-0.01, 0.01}) {
          if (const auto near = hit(box, ray_through(kCamera, u + du, v))) slack += std::fabs(*near - *z);
          if (const auto near = hit(box, ray_through(kCamera, u, v + du))) slack += std::fabs(*near - *z);
        }
        ASSERT_NEAR(1.0 / static_cast<double>(q), *z, slack);
      }
    }
  }
  EXPECT_GT(compared, 2000);
}

TEST(Raster, SphereDepthAndIncidence) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  const Vec3f centre{100, -50, 2000};
  const double radius = 300;
  WorldMesh mesh;
  add_sphere(mesh, centre, 300, 120);
  CleanView view(k.width, k.height);
  MeshRaster raster;
  raster.draw(mesh.vertices, mesh.triangles, kLabel, true, k, whole(k.width, k.height), view);
  int inside = 0;
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const Ray r = ray_through(k, u, v);
      const double a = r.x * r.x + r.y * r.y + 1;
      const double b = r.x * 100 + r.y * -50 + 2000;
      const double c = 100 * 100 + 50 * 50 + 2000.0 * 2000 - radius * radius;
      const double rest = b * b - a * c;
      // How far from the rim, as the incidence cosine.
      const double cosine = rest > 0 ? std::sqrt(rest / a) / radius : 0;
      const std::size_t at = view.at(u, v);
      if (rest < -a * 3 * radius) {
        ASSERT_EQ(view.inverse_depth[at], 0.0F);
      } else if (cosine > 0.15) {
        ++inside;
        ASSERT_GT(view.inverse_depth[at], 0.0F) << u << "," << v;
        const double z = (b - std::sqrt(rest)) / a;
        ASSERT_NEAR(1.0 / static_cast<double>(view.inverse_depth[at]), z, 0.35 / cosine);
        ASSERT_NEAR(view.cosine[at] / 255.0, cosine, 0.04);
      }
    }
  }
  EXPECT_NEAR(inside, std::acos(-1.0) * std::pow(radius * 287.9 / 2000, 2), 600);
}

// Outlines through pixel centres: neighbours share an edge, every centre belongs to exactly one of the two.
TEST(Raster, SharedEdgesBelongToOneTriangle) {
  const Intrinsics k{32, 32, 100, 100, 0, 0};
  const float z = 100;  // one mm is one pixel
  const std::array<Vec3f, 4> corners = {Vec3f{4, 4, z}, Vec3f{20, 4, z}, Vec3f{20, 20, z}, Vec3f{4, 20, z}};
  for (const auto& pair : {std::array<Triangle, 2>{{{0, 1, 2}, {0, 2, 3}}}, {{{1, 2, 3}, {1, 3, 0}}}}) {
    std::array<CleanView, 2> views = {CleanView(32, 32), CleanView(32, 32)};
    MeshRaster raster;
    for (std::size_t i = 0; i < 2; ++i)
      raster.draw(corners, std::span(&pair[i], 1), kLabel, false, k, whole(32, 32), views[i]);
    for (int v = 0; v < 32; ++v) {
      for (int u = 0; u < 32; ++u) {
        const int count =
            (views[0].inverse_depth[views[0].at(u, v)] > 0) + (views[1].inverse_depth[views[1].at(u, v)] > 0);
        // Top and left borders belong to the square, bottom and right ones do not.
        EXPECT_EQ(count, u >= 4 && u < 20 && v >= 4 && v < 20 ? 1 : 0) << u << "," << v;
      }
    }
  }
}

TEST(Raster, ClosedMeshHasNoHolesAndNoBackFaces) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  WorldMesh mesh;
  add_sphere(mesh, {0, 0, 1500}, 400, 40);
  CleanView culled(k.width, k.height), all(k.width, k.height);
  MeshRaster raster;
  raster.draw(mesh.vertices, mesh.triangles, kLabel, true, k, whole(k.width, k.height), culled);
  raster.draw(mesh.vertices, mesh.triangles, kLabel, false, k, whole(k.width, k.height), all);
  EXPECT_EQ(culled.inverse_depth, all.inverse_depth);
}

TEST(Raster, RoomPlanesMatchRays) {
  const Intrinsics k = kinect_intrinsics(320, 240);
  const std::array<Plane, 2> planes = {Plane{normalized({0.1F, 0.05F, 1}), 2500}, Plane{{0, 1, 0}, 900}};
  CleanView view(k.width, k.height);
  draw_room(planes, k, whole(k.width, k.height), view);
  for (int v = 0; v < k.height; v += 7) {
    for (int u = 0; u < k.width; u += 7) {
      const Ray r = ray_through(k, u, v);
      double z = 1e30, cosine = 0;
      for (const Plane& p : planes) {
        const double along = static_cast<double>(p.normal.x) * r.x + static_cast<double>(p.normal.y) * r.y +
                             static_cast<double>(p.normal.z);
        const double t = static_cast<double>(p.distance_mm) / along;
        if (along > 0 && t < z) z = t, cosine = along / std::sqrt(r.x * r.x + r.y * r.y + 1);
      }
      EXPECT_NEAR(1.0 / static_cast<double>(view.inverse_depth[view.at(u, v)]), z, z * 1e-5);
      EXPECT_NEAR(view.cosine[view.at(u, v)] / 255.0, cosine, 0.003);
    }
  }
}

TEST(Raster, PartsBehindTheCameraAreLeftOut) {
  WorldMesh mesh;
  add_box(mesh, {0, 0, 0}, {400, 400, 400});  // about the camera
  CleanView view(kCamera.width, kCamera.height);
  MeshRaster raster;
  const PixelBox touched = raster.draw(mesh.vertices, mesh.triangles, kLabel, false, kCamera, whole(64, 48), view);
  for (const float q : view.inverse_depth) EXPECT_LE(q, 1 / kNearMm);
  EXPECT_LE(touched.u1, 64);
}

}  // namespace
}  // namespace im2fit::lab
