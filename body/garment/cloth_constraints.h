// SPDX-License-Identifier: Apache-2.0
// What holds cloth together, in batches of four that share no vertex: lengths of edges and the angle over each.
//
// Constraints are coloured greedily in the order of the mesh, so that those of one colour touch no vertex twice, and
// solved colour after colour (Gauss-Seidel, as Müller et al. 2007 do): four of a colour at once give the bits of one
// after another, and the order is the same on every machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "body/garment/garment_mesh.h"
#include "body/garment/lanes.h"

namespace im2fit::body {

// Weight and bending stiffness are both taken at a quarter: cloth hangs in the same folds, and one pass a substep
// leaves half the strain.
inline constexpr float kWeightShare = 0.25F;

// A vertex of cloth: place in mm and the inverse of its mass, 1/kg.
struct alignas(16) ClothVertex {
  float x = 0, y = 0, z = 0, inverse_mass = 0;
};

struct StretchBatch {
  std::array<std::int32_t, 4> a, b;
  Float4 length;      // mm, at rest
  Float4 compliance;  // m/N: the inverse of kg/s²
};
// Quadratic bending over an edge (Bergou et al. 2006): |sum of k_i x_i|², isometric, so linear in places.
struct BendBatch {
  std::array<std::array<std::int32_t, 4>, 4> vertex;  // [corner][lane]
  std::array<Float4, 4> factor;
  Float4 compliance;
};

// Where an edge of a band is kept.
struct BandEdge {
  std::size_t edge, batch;
  int lane;
  float length;  // as cut, mm
};

struct ClothConstraints {
  std::vector<StretchBatch> stretch;
  std::vector<BendBatch> bend;
  std::vector<float> mass_kg;                      // a vertex each
  std::vector<std::array<std::int32_t, 2>> edges;  // every edge once
  std::vector<float> edge_mm;                      // at rest
  std::vector<BandEdge> band;                      // edges along openings
  int stretch_colours = 0, bend_colours = 0;
};
// Empty places of a batch name vertex_count(): the caller keeps a vertex of no mass there.
ClothConstraints constrain(const GarmentMesh& mesh, const Fabric& fabric);

// One pass. `inverse_h2`: 1 / s² of the substep. Batches in order.
void solve_stretch(std::span<const StretchBatch> batches, float inverse_h2, ClothVertex* vertices);
void solve_bend(std::span<const BendBatch> batches, float inverse_h2, ClothVertex* vertices);

}  // namespace im2fit::body
