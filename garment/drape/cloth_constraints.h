// SPDX-License-Identifier: Apache-2.0
// What holds cloth together: lengths of edges, in batches of four that share no vertex, and the angle over each.
//
// Constraints are coloured greedily in the order of the mesh, so that those of one colour touch no vertex twice, and
// solved colour after colour (Gauss-Seidel, as Müller et al. 2007 do): several of a colour at once give the bits of
// one after another, and the order is the same on every machine.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "garment/drape/garment_mesh.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace im2fit::body {

// Four floats at a time, in one source for all machines: GCC and Clang turn these into SSE2, NEON (aarch64) or four
// scalar operations (ARMv7, whose vectors take denormal numbers for zero). Each lane rounds as a float does, so the
// bits are the same everywhere.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = int __attribute__((vector_size(16)));

inline Float4 all_of(float v) {
  return Float4{v, v, v, v};
}
inline Float4 sqrt_of(Float4 v) {
#if defined(__SSE2__)
  return reinterpret_cast<Float4>(_mm_sqrt_ps(reinterpret_cast<__m128>(v)));  // rounded as std::sqrt is
#else
  return Float4{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
#endif
}
// The first three lanes, in order.
inline float sum3(Float4 v) {
  return v[0] + v[1] + v[2];
}
// Rows become columns.
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) {
  const Float4 ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5),
               ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Float4 cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5),
               cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
  c = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
  d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

// Weight and bending stiffness are both taken at a quarter: cloth hangs in the same folds, and one pass a substep
// leaves half the strain.
inline constexpr float kWeightShare = 0.25F;

// A vertex of cloth: its place in mm, and a lane of nought.
struct alignas(16) ClothVertex {
  float x = 0, y = 0, z = 0, none = 0;
};
inline Float4 load(const ClothVertex& vertex) {
  Float4 row;
  std::memcpy(&row, &vertex, sizeof row);
  return row;
}
inline void store(ClothVertex& vertex, Float4 row) {
  std::memcpy(static_cast<void*>(&vertex), &row, sizeof row);
}

// Masses and compliances never change, so their effect on a step is precomputed: the share of an edge's excess that
// each end corrects, and the share of a hinge's bend that each corner corrects.
struct StretchBatch {
  std::array<std::int32_t, 4> a, b;
  Float4 length;  // mm, at rest
  Float4 share_a, share_b;
};
// Quadratic bending over an edge (Bergou et al. 2006): |sum of k_i x_i|², isometric, so linear in places.
struct BendHinge {
  std::array<std::int32_t, 4> vertex;
  Float4 factor, share;
};

// A vertex of a rim and its two neighbours on either side: where the middle lies off the cubic through the others.
// Nought where a rim bends evenly, however far it bends.
struct RimSpan {
  std::array<std::int32_t, 5> vertex;
  std::array<float, 5> share;
};
inline constexpr std::array<float, 5> kRimFactor = {1.0F / 6, -4.0F / 6, 1, -4.0F / 6, 1.0F / 6};

// Where an edge of a band is kept.
struct BandEdge {
  std::size_t edge, batch;
  int lane;
  float length;  // as cut, mm
};

struct ClothConstraints {
  std::vector<StretchBatch> stretch;
  std::vector<BendHinge> bend;
  std::vector<RimSpan> rims;
  std::vector<std::array<std::int32_t, 2>> edges;  // every edge once
  std::vector<float> edge_mm;                      // at rest
  std::vector<BandEdge> band;                      // edges along openings
  int stretch_colours = 0, bend_colours = 0;
};
// `step_s`: of a pass of stretch; bending has one each second step. Empty places of a batch name vertex_count(): the
// caller keeps a vertex there.
ClothConstraints constrain(const GarmentMesh& mesh, const Fabric& fabric, float step_s);

// One pass, in order.
void solve_stretch(std::span<const StretchBatch> batches, ClothVertex* vertices);
void solve_bend(std::span<const BendHinge> hinges, ClothVertex* vertices);
void solve_rims(std::span<const RimSpan> rims, ClothVertex* vertices);

}  // namespace im2fit::body
