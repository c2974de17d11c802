// SPDX-License-Identifier: Apache-2.0
// The skin that cloth lies on, at the beginning and at the end of a frame: where it is, and which way it faces.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "body/model.h"
#include "body/skeleton.h"

namespace im2fit::body {

// Limbs as bits: cloth of a sleeve touches no other arm, a trouser leg no other leg.
inline constexpr std::uint8_t kTrunk = 1, kLeftArm = 2, kRightArm = 4, kLeftLeg = 8, kRightLeg = 16;

// A place on the skin: a triangle and the shares of its corners.
struct SkinPlace {
  std::int32_t triangle = -1;  // of BodySurface::triangles()
  std::array<float, 3> share{};
};

// Holds trunk, arms and legs: heads and feet touch no cloth, hands that of long sleeves alone. No allocation after
// construction. + - * / and sqrt only. The model must outlive it.
class BodySurface {
 public:
  explicit BodySurface(const BodyModel& model, bool hands = false);

  // `posed`: the body's vertices at the end of the next frame; the end of the last frame becomes the beginning.
  void advance(std::span<const Vec3f> posed);
  // Beginning and end alike.
  void put(std::span<const Vec3f> posed);

  std::span<const std::array<std::int32_t, 3>> triangles() const { return triangles_; }
  std::span<const std::int32_t> vertices() const { return vertices_; }
  std::uint8_t limbs(std::int32_t vertex) const { return limbs_[static_cast<std::size_t>(vertex)]; }
  // Indexed by vertices of the model.
  std::span<const Vec3f> position(bool at_end) const { return at_end ? end_ : begin_; }
  std::span<const Vec3f> normal(bool at_end) const { return at_end ? end_normal_ : begin_normal_; }
  // The farthest that a vertex moves between beginning and end, and whether that is less than kStillMm.
  float moved_mm() const { return moved_mm_; }
  bool still() const { return moved_mm_ < kStillMm; }
  static constexpr float kStillMm = 0.01F;

  // The place at the beginning nearest to `point`, by the vertex nearest to it within `reach_mm` that faces as
  // `facing` does (cosine above `cosine`) and belongs to one of `limbs`, and the triangles about that vertex. `hint`:
  // that vertex of the last frame, or -1; kept up. False when there is none.
  bool nearest(Vec3f point, Vec3f facing, float cosine, std::uint8_t limbs, float reach_mm, std::int32_t& hint,
               SkinPlace& place) const;
  // The same, a quarter of the work, where the place moved little since it was found: from `hint` over neighbours to
  // ever nearer vertices. What is nearer beyond a farther one is not found. `place`: the last one, or triangle -1.
  bool follow(Vec3f point, Vec3f facing, float cosine, std::uint8_t limbs, float reach_mm, std::int32_t& hint,
              SkinPlace& place) const;
  // The same of the skin at the end. False, too, where the hint is out of reach.
  bool follow_at_end(Vec3f point, Vec3f facing, float cosine, std::uint8_t limbs, float reach_mm, std::int32_t& hint,
                     SkinPlace& place) const;
  Vec3f at(const SkinPlace& place, bool at_end) const;
  Vec3f facing(const SkinPlace& place, bool at_end) const;  // unit
  Vec3f along(const SkinPlace& place, bool at_end) const;   // unit, square to facing(), the same way in all poses

 private:
  void end_at(std::span<const Vec3f> posed);
  void build_grid();
  std::int32_t walk(Vec3f point, Vec3f facing, float cosine, std::uint8_t limbs, float reach_mm, std::int32_t from,
                    bool at_end) const;
  bool closest_from(std::int32_t last, std::int32_t found, Vec3f point, SkinPlace& place, bool at_end) const;
  bool closest_about(std::int32_t vertex, Vec3f point, SkinPlace& place, bool at_end) const;
  int cell(float value, float low, int count) const;
  static void normals(std::span<const std::array<std::int32_t, 3>> triangles, std::span<const std::int32_t> vertices,
                      std::span<const Vec3f> positions, std::span<Vec3f> out);

  std::vector<std::int32_t> vertices_;  // of the model, that count
  std::vector<std::array<std::int32_t, 3>> triangles_;
  std::vector<std::int32_t> fan_first_, fan_;    // triangles about a vertex
  std::vector<std::int32_t> ring_first_, ring_;  // vertices about a vertex
  std::vector<std::uint8_t> limbs_;
  std::vector<Vec3f> begin_, end_, begin_normal_, end_normal_;
  float moved_mm_ = 0;
  // Vertices by cells of a grid about the body at the beginning.
  Vec3f low_;
  std::array<int, 3> cells_{1, 1, 1};
  float cell_mm_ = 20;
  struct Candidate {
    Vec3f at, facing;
    std::int32_t vertex = 0;
    std::uint8_t limbs = 0;
  };
  std::vector<Candidate> candidates_;  // by cells
  std::vector<std::int32_t> cell_first_, vertex_cell_;
};

}  // namespace im2fit::body
