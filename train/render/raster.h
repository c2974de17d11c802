// SPDX-License-Identifier: Apache-2.0
// What an ideal depth camera sees: planes and triangle meshes into an inverse-depth buffer.
//
// Inverse depth is affine over the picture of a plane, so perspective-correct interpolation needs no division per
// pixel. Integer pixel coordinates are pixel centres (core/camera.h); a centre on a shared edge belongs to
// exactly one triangle (top-left rule on coordinates snapped to 1/256 px).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/vec3.h"

namespace im2fit::lab {

// Pixels u0 <= u < u1, v0 <= v < v1.
struct PixelBox {
  int u0 = 0, v0 = 0, u1 = 0, v1 = 0;
  bool empty() const { return u0 >= u1 || v0 >= v1; }
};
PixelBox whole(int width, int height);
PixelBox intersect(const PixelBox& a, const PixelBox& b);
PixelBox bounding(const PixelBox& a, const PixelBox& b);  // an empty box counts for nothing
PixelBox grown(const PixelBox& box, int margin_px);

// People have the top bit, their number (0 the main person .. 62) in the middle and their hair in the lowest.
enum Label : std::uint8_t { kNothing = 0, kRoom = 1, kFurniture = 2, kPerson = 128, kHair = 129 };
constexpr std::uint8_t label_of(std::size_t who, bool hair) {
  return static_cast<std::uint8_t>(kPerson | (who << 1) | (hair ? 1U : 0U));
}
constexpr bool is_person(std::uint8_t label) {
  return (label & kPerson) != 0;
}
constexpr bool is_hair(std::uint8_t label) {
  return (label & kHair) == kHair;
}
constexpr std::uint8_t mask_value(std::uint8_t label) {  // 255 - who for people, else 0
  return static_cast<std::uint8_t>(is_person(label) ? 255 - ((label & 0x7F) >> 1) : 0);
}
// Of a pixel that is a person's but whose depth lies between two surfaces: 127 - who for people, else 0.
constexpr std::uint8_t mixed_mask_value(std::uint8_t label) {
  return static_cast<std::uint8_t>(mask_value(label) & 0x7F);
}

// One buffer per quantity, row-major.
struct CleanView {
  CleanView(int width, int height);
  int width;
  int height;
  std::vector<float> inverse_depth;  // 1/mm, 0 = nothing there
  std::vector<std::uint8_t> cosine;  // of the incidence angle, 0 (grazing) .. 255 (head-on)
  std::vector<std::uint8_t> label;
  std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
  }
};
void clear(CleanView& view, const PixelBox& box);
void copy_box(const CleanView& from, const PixelBox& box, CleanView& to);

// dot(normal, x) = distance_mm in camera axes; unit normal pointing away from the camera, distance_mm > 0.
struct Plane {
  Vec3f normal;
  float distance_mm = 1;
};
// The inside of the convex room these planes bound, overwriting `box`. Label kRoom.
void draw_room(std::span<const Plane> planes, const Intrinsics& k, const PixelBox& box, CleanView& view);

using Triangle = std::array<std::int32_t, 3>;

// Triangles nearer than kNearMm, or partly so, are left out.
inline constexpr float kNearMm = 100;

// Keeps its scratch between calls. Not shareable between threads.
class MeshRaster {
 public:
  // `labels`: one per triangle, or one for all. `closed`: outward triangles seen from behind are skipped (closed
  // meshes only). Vertices in camera axes, mm. Returns the box of pixels that may have changed.
  PixelBox draw(std::span<const Vec3f> vertices, std::span<const Triangle> triangles,
                std::span<const std::uint8_t> labels, bool closed, const Intrinsics& k, const PixelBox& clip,
                CleanView& view);

 private:
  struct Projected {
    std::int32_t x = 0, y = 0;  // 1/256 px; both INT32_MIN: not drawable
    float inverse_z = 0;
  };
  struct Target {
    CleanView& view;
    const PixelBox& clip;
    PixelBox touched;
  };
  void fill(std::span<const Vec3f> vertices, const Triangle& triangle, std::uint8_t label, bool closed,
            Target& target) const;
  static std::uint32_t cell_of(const Projected& p);
  bool between_centres(const Triangle& t) const;
  std::vector<Projected> projected_;
  std::vector<std::uint32_t> cells_;  // a vertex
};

}  // namespace im2fit::lab
