// SPDX-License-Identifier: Apache-2.0
// How good a drape is, in numbers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "garment/drape/outfit.h"

namespace im2fit::lab {

struct DrapeQuality {
  float strain_mean = 0, strain_p95 = 0, strain_peak = 0;  // of edges, lengthened by this share
  float inside_share = 0, inside_deepest_mm = 0;           // cloth vertices under the skin nearest to them
  float folds_mm = 0;          // root mean square distance from the garment smoothed by 20 Taubin passes
  float hem_roughness_mm = 0;  // largest distance of a hem or opening vertex from its neighbours' cubic
  bool finite = true;
};
DrapeQuality judge(const body::Outfit& outfit, std::size_t cloth);

// How much of a garment lies under the skin where that is at the beginning of the frame, were it at these places.
struct Inside {
  float share = 0, deepest_mm = 0;  // of its vertices
};
Inside judge_inside(const body::BodySurface& skin, const body::Cloth& cloth, std::span<const Vec3f> places);

// Root mean square and largest motion of the vertices since `before`, mm.
struct Motion {
  float rms_mm = 0, most_mm = 0;
};
Motion motion_since(const body::Cloth& cloth, const std::vector<Vec3f>& before);
std::vector<Vec3f> positions_of(const body::Cloth& cloth);

// The free edges of a garment in their order, hems and openings. A rim that touches itself in a vertex comes in
// pieces, which do not close.
struct Rim {
  std::vector<std::int32_t> vertices;
  bool closed = false;
};
std::vector<Rim> rims_of(const body::GarmentMesh& mesh);

// The largest distance of a rim's vertex from the cubic through its four neighbours, were the cloth at these places.
float rim_roughness_mm(const body::GarmentMesh& mesh, std::span<const Vec3f> places);

// Length round the lowest hem, mm: draped, and in the pattern.
float hem_girth_mm(const body::Cloth& cloth, bool in_pattern);

// FNV-1a of all places' bits.
std::uint64_t fingerprint(const body::Cloth& cloth);

}  // namespace im2fit::lab
