// SPDX-License-Identifier: Apache-2.0
// Cloth against itself: pairs of vertices that are near in space and far apart in the pattern, found once a frame.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "garment/drape/cloth_constraints.h"
#include "garment/drape/garment_mesh.h"

namespace im2fit::body {

// No allocation after construction. More pairs than it holds room for (four a vertex) are left out.
class ClothLayers {
 public:
  explicit ClothLayers(const GarmentMesh& mesh);
  // Of vertices nearer than search_mm(); `vertices`: of the mesh. Two that are both `pinched` (1) between skins are
  // left alone: the skins that press them are stronger.
  void find(std::span<const ClothVertex> vertices, std::span<const std::uint8_t> pinched);
  void clear() { pairs_.clear(); }
  // Pushes pairs apart to apart_mm(), half the way a call, and lets them rub. `before`: places a substep ago.
  void solve(std::span<ClothVertex> vertices, std::span<const ClothVertex> before) const;
  std::size_t pair_count() const { return pairs_.size(); }

  // Less than the lattice's edges, so that vertices meet before faces pass.
  float apart_mm() const { return 0.75F * mesh_.edge_mm; }
  float search_mm() const { return 1.2F * mesh_.edge_mm; }

 private:
  bool neighbours(std::int32_t a, std::int32_t b) const;
  const GarmentMesh& mesh_;
  std::size_t cells_max_;
  float neighbour_mm_;             // so near in the pattern two vertices are held apart by their own edges
  std::vector<float> to_seam_mm_;  // in the pattern
  std::vector<std::array<std::int32_t, 2>> pairs_;
  std::vector<std::int32_t> cell_first_, cell_vertices_, vertex_cell_;
};

}  // namespace im2fit::body
