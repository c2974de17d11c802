// SPDX-License-Identifier: Apache-2.0
// A cut pattern sewn: the triangles of front and back, left and right, with seam vertices shared.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/vec3.h"
#include "garment/pattern.h"

namespace im2fit::body {

// Edges of the lattice: finer costs twice as much and shows little.
inline constexpr float kGarmentEdgeMm = 12;
// Of the mesh a garment is put on as: a fifth of the vertices. Of 32 mm, armpits are inside.
inline constexpr float kRoughEdgeMm = 28;
// Of the mesh it is simulated as while its wearer moves.
inline constexpr float kMovingEdgeMm = 24;
inline constexpr std::uint8_t kOnSeam = 1, kOnHem = 2, kOnOpening = 4;
inline constexpr std::uint8_t kFrontLayer = 0, kBackLayer = 1, kBothLayers = 2;

struct GarmentMesh {
  float edge_mm = kGarmentEdgeMm;  // of its lattice
  Hang hang = Hang::shoulders;
  bool legs = false;
  std::vector<Flat> flat;            // place in the pattern of the left half, mm: of both sides
  std::vector<std::int8_t> side;     // 1 left, -1 right, 0 on the centre line
  std::vector<std::uint8_t> layer;   // kFrontLayer, kBackLayer, kBothLayers
  std::vector<std::uint8_t> border;  // kOnSeam | kOnHem | kOnOpening
  std::vector<float> longer;         // cloth is there so many times as long as drawn: 1, more in a gusset
  std::vector<float> rim_mm;         // in the pattern, to the nearest hem or opening of the same panel
  std::vector<std::array<std::int32_t, 3>> triangles;  // anticlockwise seen from outside
  Flat underarm;   // of what hangs from the shoulders: the corner between side and sleeve
  CutBody body{};  // it is cut for

  std::size_t vertex_count() const { return flat.size(); }
  // Of cloth at rest, between two vertices of a triangle.
  float length_mm(std::size_t a, std::size_t b) const;
};

// Whether a sleeve is so long that it may hang over a hand.
bool reaches_hand(const GarmentMesh& mesh);
// Adds the distance of each vertex from the nearest seam of its side, in the pattern.
void add_seam_distances_mm(const GarmentMesh& mesh, std::vector<float>& out);

GarmentMesh sew(const GarmentPattern& pattern, const CutBody& body, float edge_mm = kGarmentEdgeMm);

}  // namespace im2fit::body
