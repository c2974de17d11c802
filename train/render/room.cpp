// SPDX-License-Identifier: Apache-2.0
#include "train/render/room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "train/common/draw.h"

namespace im2fit::lab {
namespace {

constexpr float kClearMm = 120;

// A piece in its own axes: origin on the floor, front towards +z.
class Piece {
 public:
  void box(Vec3f centre, Vec3f size) { add_box(mesh_, centre, size); }
  void ball(Vec3f centre, float radius) { add_sphere(mesh_, centre, radius, 8); }
  WorldMesh& mesh() { return mesh_; }

 private:
  WorldMesh mesh_;
};

void four_legs(Piece& piece, float width, float depth, float height, float thickness) {
  for (const float x : {-1.0F, 1.0F})
    for (const float z : {-1.0F, 1.0F})
      piece.box({x * (width - thickness) / 2, height / 2, z * (depth - thickness) / 2},
                {thickness, height, thickness});
}

Piece table(Rng& rng) {
  Piece p;
  const float w = draw(rng, 600, 1400), d = draw(rng, 500, 800), h = draw(rng, 450, 780);
  p.box({0, h - 15, 0}, {w, 30, d});
  four_legs(p, w - 60, d - 60, h - 30, draw(rng, 35, 70));
  return p;
}

Piece chair(Rng& rng) {
  Piece p;
  const float w = draw(rng, 400, 520), seat = draw(rng, 420, 480), h = draw(rng, 780, 1050);
  p.box({0, seat, 0}, {w, 40, w});
  p.box({0, (seat + h) / 2 + 60, -w / 2 + 15}, {w, h - seat - 120, 30});
  four_legs(p, w, w, seat, 35);
  return p;
}

Piece shelf(Rng& rng) {
  Piece p;
  const float w = draw(rng, 500, 1000), d = draw(rng, 250, 450), h = draw(rng, 900, 2000);
  for (const float x : {-1.0F, 1.0F}) p.box({x * (w - 20) / 2, h / 2, 0}, {20, h, d});
  p.box({0, h / 2, -d / 2 + 5}, {w, h, 10});
  const int boards = 3 + rng.index(3);
  for (int i = 0; i <= boards; ++i)
    p.box({0, 10 + (h - 20) * static_cast<float>(i) / static_cast<float>(boards), 0}, {w, 20, d});
  return p;
}

Piece cartons(Rng& rng) {
  Piece p;
  float bottom = 0;
  const int count = 1 + rng.index(3);
  for (int i = 0; i < count; ++i) {
    const float h = draw(rng, 200, 450);
    p.box({draw(rng, -40, 40), bottom + h / 2, draw(rng, -40, 40)}, {draw(rng, 300, 600), h, draw(rng, 300, 500)});
    bottom += h;
  }
  return p;
}

Piece coat_stand(Rng& rng) {
  Piece p;
  const float h = draw(rng, 1600, 1900);
  p.box({0, h / 2, 0}, {40, h, 40});
  p.box({0, 15, 0}, {350, 30, 350});
  p.box({0, h - 60, 0}, {400, 25, 25});
  p.box({0, h - 140, 0}, {25, 25, 400});
  // A coat: about as wide as a trunk, hanging from the hooks; a hat above half of them.
  p.box({draw(rng, -80, 80), h - 520, 60}, {draw(rng, 300, 450), 760, draw(rng, 90, 180)});
  if (rng.index(2) == 0) p.ball({0, h + 40, 0}, draw(rng, 90, 130));
  return p;
}

Piece coated_chair(Rng& rng) {
  Piece p = chair(rng);
  // A coat over the back, to the floor or nearly; now and then a hat on top.
  const float h = draw(rng, 950, 1250), w = draw(rng, 420, 520);
  p.box({draw(rng, -20, 20), h / 2 + 60, -200}, {w, h - 120, draw(rng, 110, 170)});
  if (rng.index(3) == 0) p.ball({0, h + 90, -200}, draw(rng, 90, 120));
  return p;
}

Piece dog(Rng& rng) {
  Piece p;
  const float length = draw(rng, 500, 900), h = draw(rng, 420, 700), w = draw(rng, 180, 280);
  p.box({0, h * 0.68F, 0}, {w, h * 0.42F, length});
  four_legs(p, w, length, h * 0.5F, 60);
  p.box({0, h * 0.98F, length / 2 + 60}, {w * 0.6F, h * 0.3F, 220});
  return p;
}

// Low enough to pass under hanging hands.
Piece low_piece(Rng& rng) {
  Piece p;
  const float h = draw(rng, 180, 480), w = draw(rng, 200, 420), d = draw(rng, 200, 420);
  switch (rng.index(3)) {
    case 0:
      return dog(rng);
    case 1:  // stool or side table
      p.box({0, h - 15, 0}, {w, 30, d});
      four_legs(p, w, d, h - 30, 35);
      return p;
    default:  // bag or carton
      p.box({0, h / 2, 0}, {w, h, d});
      return p;
  }
}

struct Extent {
  float x_low = 0, x_high = 0, z_low = 0, z_high = 0;
};
Extent extent_of(const WorldMesh& mesh) {
  Extent e{1e9F, -1e9F, 1e9F, -1e9F};
  for (const Vec3f& v : mesh.vertices) {
    e.x_low = std::min(e.x_low, v.x);
    e.x_high = std::max(e.x_high, v.x);
    e.z_low = std::min(e.z_low, v.z);
    e.z_high = std::max(e.z_high, v.z);
  }
  return e;
}

bool in_the_way(const Extent& e, float x, float z, const Standing& standing) {
  for (const Vec3f& spot : standing.others)
    if (spot.x > x + e.x_low - kOthersClearMm && spot.x < x + e.x_high + kOthersClearMm &&
        spot.z > z + e.z_low - kOthersClearMm && spot.z < z + e.z_high + kOthersClearMm)
      return true;
  return false;
}

void turn(WorldMesh& mesh, float yaw_deg) {
  const float a = yaw_deg * std::numbers::pi_v<float> / 180;
  const float c = std::cos(a), s = std::sin(a);
  for (Vec3f& v : mesh.vertices) v = {c * v.x + s * v.z, v.y, -s * v.x + c * v.z};
}

void place(const WorldMesh& piece, Vec3f at, WorldMesh& out) {
  const auto first = static_cast<std::int32_t>(out.vertices.size());
  for (const Vec3f& v : piece.vertices) out.vertices.push_back(v + at);
  for (const Triangle& t : piece.triangles) out.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

Piece draw_piece(Rng& rng) {
  switch (rng.index(5)) {
    case 0:
      return table(rng);
    case 1:
      return chair(rng);
    case 2:
      return shelf(rng);
    case 3:
      return cartons(rng);
    default:
      return coat_stand(rng);
  }
}

void furnish(const RoomOptions& options, const Standing& person, Rng& rng, WorldMesh& out) {
  for (int i = 0; i < options.furniture_count; ++i) {
    Piece piece = draw_piece(rng);
    const bool at_wall = options.walls && rng.uniform() < 0.5;
    turn(piece.mesh(), at_wall ? 0.0F : draw(rng, -40, 40));
    const Extent e = extent_of(piece.mesh());
    const float wall_z = options.walls ? -options.wall_distance_mm : -2000.0F;
    const bool beside = rng.index(2) == 0;
    const float touching_z = wall_z + 5 - e.z_low;
    // Behind: the front edge stays behind the person's back. Beside: the inner edge stays outside the person, and
    // the piece does not come nearer to the camera than 250 mm before the person.
    const float z_max = beside ? 250 - e.z_high : -person.behind_mm - kClearMm - e.z_high;
    if (touching_z > z_max) continue;  // the wall is too near for this piece
    const float z = at_wall ? touching_z : draw(rng, static_cast<double>(touching_z), static_cast<double>(z_max));
    float x = draw(rng, -1200, 1200);
    if (beside) {
      const float inner = person.half_width_mm + kClearMm;
      x = x < 0 ? -inner - e.x_high + x * 0.4F : inner - e.x_low + x * 0.4F;
    }
    if (!in_the_way(e, x, z, person)) place(piece.mesh(), {x, 0, z}, out);
  }
}

// Beside the lower legs or right behind the heels, 0..40 mm away.
void touch_legs(const Standing& person, Rng& rng, WorldMesh& out) {
  const int count = 1 + rng.index(2);
  const int first = rng.index(3);
  for (int i = 0; i < count; ++i) {
    Piece piece = low_piece(rng);
    turn(piece.mesh(), draw(rng, -25, 25));
    const Extent e = extent_of(piece.mesh());
    const float gap = draw(rng, 0, 40);
    const float middle_z = (e.z_low + e.z_high) / 2;
    const float z = std::min(draw(rng, -150, 120) - middle_z, 200 - e.z_high);
    switch ((first + i) % 3) {
      case 0:
        place(piece.mesh(), {person.legs_left_mm - gap - e.x_high, 0, z}, out);
        break;
      case 1:
        place(piece.mesh(), {person.legs_right_mm + gap - e.x_low, 0, z}, out);
        break;
      default:
        place(piece.mesh(), {draw(rng, -150, 150), 0, person.legs_back_mm - gap - e.z_high}, out);
    }
  }
}

void place_decoys(const RoomOptions& options, const Standing& person, Rng& rng, WorldMesh& out) {
  for (int i = 0; i < options.decoy_count; ++i) {
    Piece piece = rng.index(3) == 0 ? coat_stand(rng) : rng.index(2) == 0 ? coated_chair(rng) : dog(rng);
    turn(piece.mesh(), draw(rng, -70, 70));
    const Extent e = extent_of(piece.mesh());
    const float wall_z = (options.walls ? -options.wall_distance_mm : -2000.0F) + 5 - e.z_low;
    float x = draw(rng, -1000, 1000), z = draw(rng, std::min(-300.0, static_cast<double>(wall_z)), 300);
    z = std::max(z, wall_z);
    if (!options.empty_place) {
      const float inner = person.half_width_mm + kClearMm;
      x = x < 0 ? -inner - e.x_high + x * 0.3F : inner - e.x_low + x * 0.3F;
    }
    if (!in_the_way(e, x, z, person)) place(piece.mesh(), {x, 0, z}, out);
  }
}

}  // namespace

void add_box(WorldMesh& mesh, Vec3f centre, Vec3f size_mm, float yaw_deg) {
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  const float a = yaw_deg * std::numbers::pi_v<float> / 180;
  const float c = std::cos(a), s = std::sin(a);
  for (int i = 0; i < 8; ++i) {
    const float x = ((i & 1) != 0 ? 0.5F : -0.5F) * size_mm.x;
    const float y = ((i & 2) != 0 ? 0.5F : -0.5F) * size_mm.y;
    const float z = ((i & 4) != 0 ? 0.5F : -0.5F) * size_mm.z;
    mesh.vertices.push_back(centre + Vec3f{c * x + s * z, y, -s * x + c * z});
  }
  static constexpr std::array<Triangle, 12> kFaces = {{{0, 2, 3},
                                                       {0, 3, 1},
                                                       {4, 5, 7},
                                                       {4, 7, 6},
                                                       {0, 1, 5},
                                                       {0, 5, 4},
                                                       {2, 6, 7},
                                                       {2, 7, 3},
                                                       {0, 4, 6},
                                                       {0, 6, 2},
                                                       {1, 3, 7},
                                                       {1, 7, 5}}};
  for (const Triangle& t : kFaces) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

void append(const WorldMesh& from, WorldMesh& to) {
  place(from, {}, to);
}

void add_sphere(WorldMesh& mesh, Vec3f centre, float radius_mm, int rings) {
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  const int sectors = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    const float polar = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(rings);
    for (int j = 0; j < sectors; ++j) {
      const float turn_angle = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(sectors);
      mesh.vertices.push_back(centre + Vec3f{std::sin(polar) * std::cos(turn_angle), std::cos(polar),
                                             std::sin(polar) * std::sin(turn_angle)} *
                                           radius_mm);
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const int a = first + i * sectors + j, b = first + i * sectors + (j + 1) % sectors;
      if (i > 0) mesh.triangles.push_back({a, b, a + sectors});
      if (i + 1 < rings) mesh.triangles.push_back({b, b + sectors, a + sectors});
    }
  }
}

Room draw_room_plan(const RoomOptions& options, const Standing& person, Rng& rng) {
  Room room;
  if (options.floor) room.walls.push_back({{0, -1, 0}, 0});
  if (options.walls) {
    // Few cameras face a wall squarely. The offset is taken where the wall passes behind the person.
    const float yaw = static_cast<float>(rng.normal(0, 5)) * std::numbers::pi_v<float> / 180;
    room.walls.push_back({{std::sin(yaw), 0, -std::cos(yaw)}, options.wall_distance_mm * std::cos(yaw)});
    for (const float side : {-1.0F, 1.0F}) {
      const bool there = rng.uniform() < 0.4;
      float distance = draw(rng, static_cast<double>(person.half_width_mm) + 500, 2600);
      for (const Vec3f& spot : person.others) distance = std::max(distance, side * spot.x + kOthersClearMm);
      if (there) room.walls.push_back({{side, 0, 0}, distance});
    }
    room.walls.push_back({{0, 1, 0}, draw(rng, 2350, 3000)});
  }
  furnish(options, person, rng, room.furniture);
  if (options.touching) touch_legs(person, rng, room.furniture);
  place_decoys(options, person, rng, room.furniture);
  return room;
}

void draw_seat(const Seat& seat, Rng& rng, WorldMesh& out) {
  Piece p;
  const float w = std::max(seat.width_mm, draw(rng, 380, 520));
  const float depth = std::max(300.0F, seat.front_mm - seat.back_mm);
  const float middle = seat.front_mm - depth / 2, back = seat.front_mm - depth, top = seat.height_mm;
  const float thick = draw(rng, 25, 90), leg = draw(rng, 25, 50);
  p.box({0, top - thick / 2, middle}, {w, thick, depth});
  for (const float x : {-1.0F, 1.0F})
    for (const float z : {-1.0F, 1.0F})
      p.box({x * (w - leg) / 2, (top - thick) / 2, middle + z * (depth - leg) / 2}, {leg, top - thick, leg});
  if (rng.uniform() < 0.7) {
    const float h = draw(rng, 330, 560), low = draw(rng, 60, 180);
    p.box({0, top + (low + h) / 2, back - 20}, {w, h - low, 30});
    for (const float x : {-1.0F, 1.0F}) p.box({x * (w - leg) / 2, top + h / 2 - thick, back - 20}, {leg, h, leg});
    if (rng.uniform() < 0.35) {
      const float arm_y = top + draw(rng, 190, 240);
      for (const float x : {-1.0F, 1.0F}) {
        p.box({x * (w / 2 + 55), arm_y, middle}, {50, 25, depth * 0.8F});
        p.box({x * (w / 2 + 55), arm_y / 2, middle + depth * 0.3F}, {35, arm_y, 35});
        p.box({x * (w / 2 + 55), arm_y / 2, back}, {35, arm_y, 35});
      }
    }
  }
  turn(p.mesh(), seat.yaw_deg);
  place(p.mesh(), {seat.x_mm, 0, seat.z_mm}, out);
}

}  // namespace im2fit::lab
