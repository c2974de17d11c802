// SPDX-License-Identifier: Apache-2.0
// The room about the person: floor, walls, ceiling and furniture. World axes: y up, z towards the camera, x to the
// camera's right; the person stands at the origin of the floor.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/rng.h"
#include "train/render/raster.h"

namespace im2fit::lab {

// A triangle mesh in world axes, outward triangles of closed parts.
struct WorldMesh {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
};
// A box of size `size_mm` about `centre`, turned by yaw about y.
void add_box(WorldMesh& mesh, Vec3f centre, Vec3f size_mm, float yaw_deg = 0);
void append(const WorldMesh& from, WorldMesh& to);
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
  // Of what reaches below kLegsTopMm: where furniture may touch.
  float legs_left_mm = -150, legs_right_mm = 150;  // x, left as the camera sees it
  float legs_back_mm = -120;                       // z
  std::vector<Vec3f> others =
      {};  // floor points where further people stand or walk: kOthersClearMm about them stay free
};
inline constexpr float kOthersClearMm = 450;
inline constexpr float kLegsTopMm = 450;

// A seat under a person whose hips are above (x, z); front and back as for one who faces +z before the turn.
struct Seat {
  float height_mm = 450;  // of its top
  float front_mm = 250;   // z of its front edge
  float back_mm = -150;   // z of the person's back
  float width_mm = 420;
  float yaw_deg = 0;
  float x_mm = 0, z_mm = 0;
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
  bool touching = false;     // one or two pieces at the person's feet or lower legs
  int decoy_count = 0;       // what fools detectors: coat stands, chairs with a coat, dog-sized boxes
  bool empty_place = false;  // no person there: decoys may stand at the origin
};
Room draw_room_plan(const RoomOptions& options, const Standing& person, Rng& rng);
// Chair with or without arms, or a stool.
void draw_seat(const Seat& seat, Rng& rng, WorldMesh& out);

}  // namespace im2fit::lab
