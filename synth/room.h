// SPDX-License-Identifier: Apache-2.0
// The room about the person: floor, walls, ceiling and furniture. World axes: y up, z towards the camera, x to the
// camera's right; the person stands at the origin of the floor.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/rng.h"
#include "synth/raster.h"

namespace im2fit::synth {

// A triangle mesh in world axes, outward triangles of closed parts.
struct WorldMesh {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
};
// A box of size `size_mm` about `centre`, turned by yaw about y.
void add_box(WorldMesh& mesh, Vec3f centre, Vec3f size_mm, float yaw_deg = 0);
void add_sphere(WorldMesh& mesh, Vec3f centre, float radius_mm, int rings);

// dot(normal, x) <= offset_mm inside the room, world axes.
struct Wall {
  Vec3f normal;
  float offset_mm = 0;
};

// Where furniture may not be: the person's box on the floor. The pieces keep 120 mm clear of it and never stand
// between camera and person.
struct Standing {
  float half_width_mm = 500;  // |x| of the person
  float behind_mm = 200;      // -z of the person
};

struct Room {
  std::vector<Wall> walls;
  WorldMesh furniture;
};
struct RoomOptions {
  bool floor = true;
  bool walls = true;
  float wall_distance_mm = 1500;  // behind the person
  int furniture_count = 0;
};
Room draw_room_plan(const RoomOptions& options, const Standing& person, Rng& rng);

}  // namespace im2fit::synth
