// SPDX-License-Identifier: Apache-2.0
// A body in clothes: garments put on one after another, then draped frame by frame as the body moves.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "body/model.h"
#include "body/section.h"
#include "body/skeleton.h"
#include "garment/drape/body_surface.h"
#include "garment/drape/cloth.h"
#include "garment/drape/garment_mesh.h"
#include "garment/drape/refinement.h"

namespace im2fit::body {

// Not shareable between threads; the model must outlive it. No allocation after construction.
class Outfit {
 public:
  struct Piece {
    GarmentMesh mesh;
    GarmentMesh rough;  // the same cut in longer edges, as which it is put on
    Fabric fabric;
    std::optional<GarmentMesh> moving;  // and as which it is simulated while its wearer moves
  };
  // `moves`: with a mesh for that.
  static Piece piece(const GarmentPattern& pattern, const CutBody& body, const Fabric& fabric, bool moves = false);
  // `pieces`: what lies on the skin first. Allocates.
  Outfit(const BodyModel& model, std::vector<Piece> pieces);
  ~Outfit();

  // Puts all pieces on a body: `rest` has the model's vertices. Afterwards the body stands in `pose` (its translation
  // is ignored: the pelvis stays where it is at rest), and the cloth is nearly at rest. The rough meshes are put on
  // and follow into the pose; then the fine meshes replace them and fall into their own folds.
  void dress(std::span<const Vec3f> rest, const Skeleton& skeleton, const Pose& pose);
  // Advances by a thirtieth of a second, in which the body goes from its last pose to this one (translation ignored).
  void frame(const Pose& pose);
  // The same in `frames` even steps.
  void move_to(const Pose& pose, int frames);

  // Whether all pieces have a moving mesh.
  bool can_move() const { return moving_.size() == cloths_.size(); }
  // Once dressed, of such pieces: gives up all other meshes for the moving ones, which lie where the fine ones do.
  // From then on cloth() and the other functions refer to the moving meshes. Cannot be dressed again.
  void keep_moving_alone();

  std::size_t size() const { return cloths_.size(); }
  const Cloth& cloth(std::size_t i) const { return *cloths_[i]; }
  // From the moving mesh to the fine one; not after keep_moving_alone().
  const Refinement& refinement(std::size_t i) const { return from_moving_[i]; }
  const BodySurface& skin() const { return surface_; }
  std::span<const Vec3f> body() const { return posed_; }  // all vertices of the model, as the last frame ended
  const Pose& pose() const { return pose_; }
  const Skeleton& skeleton() const { return skeleton_; }  // at rest, of the body it was dressed on

  // The body's vertices that cloth hides from every direction: `out` has body_vertex_count() places, 1: hidden.
  // Skin near hems is not; `more_mm`: so much farther from them, where cloth will move.
  void hidden_skin(std::span<std::uint8_t> out, float more_mm = 0) const;
  // Where a garment's vertices are shown: those within the skin lie on it, and those that stand out of cloth worn
  // over it lie under that cloth; rims are smoother than simulated. `out` has a place a vertex of the garment.
  void shown(std::size_t index, std::span<Vec3f> out) const;
  // The same as hidden_skin of a garment's vertices below the garments over it.
  void hidden_cloth(std::size_t index, std::span<std::uint8_t> out, float more_mm = 0) const;

 private:
  // Vertices of a garment that follow one another lie near each other: a box about each kBlock of them, and one about
  // each kBlock boxes.
  // Four at a time; one of no vertex is far from everything.
  struct FourBoxes {
    using Row = std::array<float, 4>;
    static constexpr Row kFar = {1e15F, 1e15F, 1e15F, 1e15F}, kBelow = {-1e15F, -1e15F, -1e15F, -1e15F};
    std::array<Row, 3> low = {kFar, kFar, kFar}, high = {kBelow, kBelow, kBelow};
    void take(std::size_t lane, Vec3f p);
    // Which of them may hold a vertex so near, each lane not 0.
    Int4 within(Vec3f p, float squared) const;
  };
  static constexpr std::size_t kBlock = 16;
  // `p`, a place of a garment's vertex, or on the skin it lies within.
  Vec3f lifted(std::size_t index, std::size_t v, Vec3f p) const;
  static void smooth_rims(const Cloth& cloth, std::span<Vec3f> places);
  // Makes boxes_ and groups_ of the cloth as it lies now; hides() and near() are of that cloth.
  void box(const Cloth& cloth) const;
  // Calls `consider` with each vertex of the cloth that may be as near to p as the square root of `best`, in order.
  template <class F>
  void near(const Cloth& cloth, Vec3f p, const float& best, F consider) const;
  bool hides(const Cloth& cloth, Vec3f p, Vec3f n, std::uint8_t limbs, float behind_mm, float crumpled_mm,
             float rim_mm, std::size_t& hint) const;
  void add_clearance(const Cloth& cloth);
  using Cloths = std::vector<std::unique_ptr<Cloth>>;
  void put_on(std::size_t index);
  void refine();
  float girth_at_band(const Cloth& cloth, const PosedSkeleton& bones);
  void place_flat(Cloth& cloth, std::span<const float> seam_mm, const PosedSkeleton& bones);
  void run(const Cloths& cloths, const Pose& pose);
  void move(const Cloths& cloths, const Pose& pose, int frames);
  void turn_rough(const Mat3f& rotation, Vec3f about);
  void skin_body(const Pose& pose);

  const BodyModel& model_;
  std::vector<std::unique_ptr<GarmentMesh>> meshes_, rough_meshes_, moving_meshes_;
  Cloths cloths_, rough_, moving_;
  std::vector<Refinement> refinements_, from_moving_;  // to the fine meshes
  std::vector<float> belt_mm_;                         // of each garment
  std::vector<float> to_seam_mm_;                      // of all rough vertices, garment after garment
  BodySurface surface_;
  std::vector<Vec3f> rest_, posed_, axes_, drawn_, flat_;
  std::vector<Vec3f> level_, hull_points_;
  HullWork hull_;
  std::vector<float> clearance_mm_;
  mutable std::vector<FourBoxes> boxes_, groups_;
  Skeleton skeleton_;
  Pose pose_;
};

}  // namespace im2fit::body
