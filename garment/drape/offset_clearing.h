// SPDX-License-Identifier: Apache-2.0
// Offsets of a rough mesh, corrected so that the fine mesh shown by them lies off the skin. Rough cloth lies off it
// at its vertices alone: between those skin bulges, and the drape's small folds reach into it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "garment/drape/cloth.h"
#include "garment/drape/cloth_part.h"
#include "garment/drape/refinement.h"

namespace im2fit::body {

// No allocation after construction. + - * / and sqrt only.
class OffsetClearing {
 public:
  static constexpr float kOffMm = 3;  // fine vertices, the skin: faces between them stay outside
  // `fine`: as it is shown; `spots`: its vertices' places in the rough mesh.
  OffsetClearing(ClothPart fine, std::span<const Refinement::Spot> spots, const Cloth& cloth);
  // `offsets`: of the rough mesh. The skin at its end, posed as `unposing` says.
  void clear(const BodySurface& skin, const Unposing& unposing, std::span<Vec3f> offsets);

 private:
  // A fine vertex nearer to the skin than kOffMm, or behind it.
  struct Inside {
    std::int32_t vertex = 0;
    float off_mm = 0;  // the skin, with the offset it had then
    Vec3f per_offset;  // how much farther off each mm of its offset takes it
    Vec3f offset;
  };
  Vec3f offset_of(std::size_t vertex, std::span<const Vec3f> offsets) const;
  bool is_moved(std::size_t vertex) const;
  void show(const Unposing& unposing, std::span<const Vec3f> offsets);
  void update_normals();
  bool find_skin(const BodySurface& skin, std::size_t vertex);
  void find_inside(const BodySurface& skin, const Unposing& unposing, std::span<const Vec3f> offsets);
  void push_out(std::span<Vec3f> offsets);

  std::vector<Vec3f> rest_;
  std::vector<std::array<std::uint8_t, 4>> segments_;
  std::vector<std::array<float, 4>> weights_;
  std::vector<Refinement::Spot> spots_;
  std::vector<std::uint8_t> limbs_;
  std::vector<std::array<std::int32_t, 3>> triangles_;
  std::vector<Vec3f> shown_, normals_;
  std::vector<std::int32_t> hint_;
  std::vector<std::uint8_t> moved_;  // of the rough mesh, since they were looked at last
  std::vector<std::uint8_t> far_;    // so many looks ago there was no skin near; 0: there was
  std::vector<SkinPlace> place_;
  std::vector<Inside> inside_;
  unsigned looks_ = 0;
};

}  // namespace im2fit::body
