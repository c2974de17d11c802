// SPDX-License-Identifier: Apache-2.0
#include "train/render/room.h"

#include <gtest/gtest.h>

#include <cmath>

namespace im2fit::lab {
namespace {

double volume(const WorldMesh& mesh) {
  double six = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3f a = mesh.vertices[static_cast<std::size_t>(t[0])], b = mesh.vertices[static_cast<std::size_t>(t[1])],
                c = mesh.vertices[static_cast<std::size_t>(t[2])];
    six += static_cast<double>(dot(a, cross(b, c)));
  }
  return six / 6;
}

TEST(Room, SolidsFaceOutwards) {
  WorldMesh box, sphere;
  add_box(box, {100, 200, 300}, {100, 200, 300}, 30);
  add_sphere(sphere, {10, 20, 30}, 100, 60);
  EXPECT_NEAR(volume(box), 6e6, 6e2);
  EXPECT_NEAR(volume(sphere), 4.0 / 3 * std::acos(-1.0) * 1e6, 1e4);
}

// Over many rooms: nothing stands between camera and person or inside the person, and pieces do appear, some of
// them against the back wall.
TEST(Room, FurnitureKeepsClearOfThePerson) {
  int vertices = 0, touching = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Rng rng(seed);
    RoomOptions options;
    options.furniture_count = 3;
    options.wall_distance_mm = 1500;
    const Standing person{600, 250};
    const Room room = draw_room_plan(options, person, rng);
    for (const Vec3f& p : room.furniture.vertices) {
      ++vertices;
      const bool beside = std::fabs(p.x) >= 600 + 119;
      const bool behind = p.z <= -250 - 119;
      ASSERT_TRUE(beside || behind) << seed << ": " << p.x << " " << p.z;
      ASSERT_LE(p.z, 251);
      ASSERT_GT(p.y, -1);
      touching += p.z < -1480;
    }
  }
  EXPECT_GT(vertices, 10000);
  EXPECT_GT(touching, 500);
}

TEST(Room, ThePersonIsInsideTheWalls) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Rng rng(seed);
    const Room room = draw_room_plan({}, {700, 200}, rng);
    ASSERT_GE(room.walls.size(), 3U);
    for (const Wall& wall : room.walls) {
      EXPECT_NEAR(norm(wall.normal), 1, 1e-5);
      for (const float x : {-700.0F, 700.0F}) EXPECT_LE(dot(wall.normal, {x, 1800, -200}), wall.offset_mm);
    }
  }
}

}  // namespace
}  // namespace im2fit::lab
