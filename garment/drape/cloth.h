// SPDX-License-Identifier: Apache-2.0
// One garment in motion: extended position-based dynamics in small steps (Macklin et al. 2016, 2019) on the skin of a
// BodySurface. docs/garments.md says what is solved and why so.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "garment/drape/body_surface.h"
#include "garment/drape/cloth_constraints.h"
#include "garment/drape/cloth_layers.h"
#include "garment/drape/garment_mesh.h"

namespace im2fit::body {

struct ClothFrame {
  bool weightless = false;  // while a garment is put on
  bool flat = false;        // the front panel faces the front, the back panel the back, whatever its triangles say
  float damping_per_s = 2;
  bool may_sleep = false;  // see Cloth::run
};

// Not shareable between threads. No allocation after construction. + - * / and sqrt of float32 in one order: the same
// bits on every machine.
class Cloth {
 public:
  static constexpr float kSkinMm = 4;  // cloth lies so far off the skin: faces between vertices stay outside
  // A mesh of longer edges needs fewer for the same strain.
  static constexpr int kSubsteps = 16, kRoughSubsteps = 10;  // a frame
  Cloth(const GarmentMesh& mesh, const Fabric& fabric, int substeps = kSubsteps);
  Cloth(const Cloth&) = delete;
  Cloth& operator=(const Cloth&) = delete;

  void place(std::span<const Vec3f> vertices);  // at rest there, no belt held
  void carry(std::span<const Vec3f> vertices);  // the same, the belt held as it was
  // Tightens the band of a garment that hangs from the waist to this length, as a belt does; never wider than cut.
  void close_belt(float girth_mm);
  // From now on the band stays where it lies on the skin, each vertex at its height in the pattern plus `up_mm`: a
  // belt does not slide.
  void hold_belt(const BodySurface& skin, float up_mm);
  // The same of a band that lies on the skin already.
  void hold_belt_here(const BodySurface& skin);
  // Advances by a thirtieth of a second, in which the skin moves from its beginning to its end. `clearance_mm`: the
  // thickness of the clothes below at each vertex of the model; empty: none. Cloth with may_sleep stops some twenty
  // frames after its skin stood still for kAwakeFrames, and then costs nothing until the skin moves.
  void run(const BodySurface& skin, const ClothFrame& frame, std::span<const float> clearance_mm = {});

  const GarmentMesh& mesh() const { return mesh_; }
  const ClothConstraints& constraints() const { return constraints_; }
  std::span<const ClothVertex> vertices() const { return std::span(vertices_).first(mesh_.vertex_count()); }
  Vec3f position(std::size_t v) const { return {vertices_[v].x, vertices_[v].y, vertices_[v].z}; }
  std::span<const Vec3f> normals() const { return normals_; }  // of the frame's beginning; update_normals: of now
  void update_normals();
  // Which limbs' skin a vertex may touch: kTrunk, kLeftArm and so on.
  std::uint8_t limbs(std::size_t v) const { return limbs_[v]; }
  // Where a vertex lay nearest to the skin when the last frame began; triangle -1: beyond reach.
  std::span<const SkinPlace> contacts() const { return place_; }
  std::span<const std::uint8_t> pinched() const { return pinched_; }  // 1: between two skins that face each other

 private:
  struct Contact {
    Float4 point{}, point_step{};  // at the frame's beginning; what a substep adds
    Float4 normal{}, normal_step{};
    float friction = 0, clearance = 0;
    bool on = false;
  };
  struct Held {  // of a belt
    std::int32_t vertex = 0;
    SkinPlace place;
    Vec3f off_mm;  // the skin: out of it, along, and across
    Vec3f point, point_step;
  };
  struct Tether {  // a vertex and the one it hangs from, at most so far, in the pattern
    std::int32_t vertex = 0, anchor = 0;
    float most_mm = 0;
  };
  struct Stretched {  // an edge, its length at rest, and the share of what it is too long that either end makes up
                      // for
    std::int32_t a = 0, b = 0;
    float rest_mm = 0, share_a = 0, share_b = 0;
  };
  // For loops that store: for all the compiler knows a vector of floats might be stored over the members behind
  // these.
  struct Arrays {
    ClothVertex *vertices, *before, *velocity;
    std::size_t count;
  };
  Arrays arrays() { return {vertices_.data(), before_.data(), velocity_.data(), mesh_.vertex_count()}; }
  void find_ring();
  void hold_ring(const BodySurface& skin);
  void lay_belt(float up_mm);
  void follow_belt(const BodySurface& skin);
  void pull_belt(int substep);
  void touch(const BodySurface& skin, std::size_t v, const SkinPlace& place);
  static bool lies_beside(const Contact& contact, Float4 at);
  bool find_skin(const BodySurface& skin, const ClothFrame& frame, std::size_t v);
  bool yield_to_opposite_skin(const BodySurface& skin, std::size_t v);
  void leave_other_limb(const BodySurface& skin, std::size_t v);
  void fall_asleep();
  void find_contacts(const BodySurface& skin, const ClothFrame& frame, std::span<const float> clearance_mm);
  void tether();
  void hold_tethers();
  void find_stretched();
  void limit_all_strain(bool placed);
  bool limit_strain(int pass, float over_share, float to_share);
  void integrate(const ClothFrame& frame);
  void collide(int substep);
  void update_velocities();

  const GarmentMesh& mesh_;
  int substeps_;
  float step_s_;
  float push_mm_, rest_keeps_, belt_pull_;  // a substep
  float friction_;
  bool rough_;
  float pinch_reach_mm_;
  ClothConstraints constraints_;
  ClothLayers layers_;
  std::vector<ClothVertex> vertices_, before_, velocity_;  // one more than the mesh has: the empty places' vertex
  std::vector<Vec3f> normals_;
  std::vector<Contact> contacts_;
  std::vector<SkinPlace> place_;
  std::vector<Held> belt_;
  std::vector<std::int32_t> hint_, opposite_hint_;
  std::vector<float> clear_mm_;  // of a vertex beyond the skin's reach: no nearer than that before it is looked at
  std::vector<ClothVertex> frame_begin_;
  std::vector<std::int32_t> ring_;  // the band's vertices round the waist
  std::vector<Vec3f> ring_at_, ring_work_;
  int still_frames_ = 0;
  float awake_ = 1;  // the share of a frame's motion that cloth falling asleep makes
  std::vector<std::uint8_t> limbs_, pinched_;
  std::vector<std::uint8_t> joint_;  // whether limbs meet there: armpit, crotch
  std::vector<float> grip_;          // of friction
  std::vector<Tether> tethers_;
  std::vector<Stretched> stretched_;
  std::vector<std::uint16_t> moved_in_;  // of a vertex, the last of the frame's passes that moved it
  std::uint16_t strain_pass_ = 0;
  unsigned frames_ = 0;  // since the cloth was placed
};

}  // namespace im2fit::body
