// SPDX-License-Identifier: Apache-2.0
// From a garment in long edges to the same garment in short ones; or back, dropping the vertices between.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "garment/drape/cloth.h"
#include "garment/drape/garment_mesh.h"

namespace im2fit::body {

// Where the vertices of a garment's mesh lie in a rougher mesh of the same cut. No allocation after construction.
// + - * / and sqrt only.
class Refinement {
 public:
  Refinement(const GarmentMesh& rough, const GarmentMesh& fine);
  // `out`: a place a vertex of the finer mesh, on a curved surface through the rough cloth's vertices (Boubekeur and
  // Alexa 2008, Phong tessellation). The rough cloth's normals must be up to date.
  void places(const Cloth& rough, std::span<Vec3f> out) const;

  // The place of a vertex in the flat pattern: sums of three rough vertices. Shares sum to 1; of a vertex a little
  // outside all rough triangles one is below 0.
  struct Spot {
    std::array<std::int32_t, 3> corner{};  // of the rough mesh
    std::array<float, 3> share{};
  };
  std::span<const Spot> spots() const { return spots_; }  // of each vertex of the finer mesh

 private:
  std::vector<Spot> spots_;
};

}  // namespace im2fit::body
