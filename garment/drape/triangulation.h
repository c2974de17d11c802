// SPDX-License-Identifier: Apache-2.0
// A flat panel filled with triangles: a hexagonal lattice inside its outline, joined by Delaunay triangulation
// (Bowyer 1981, Watson 1981).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "garment/pattern.h"

namespace im2fit::body {

struct FilledPanel {
  std::vector<Flat> points;                            // the outline's first, in its order, then the lattice's
  std::vector<std::array<std::int32_t, 3>> triangles;  // anticlockwise
};
// `outline`: simple, closed (last to first), anticlockwise, points about `edge_mm` apart. + - * / and comparisons of
// float64 in one order: the same triangles on every machine. A point at a needle-sharp corner may belong to none.
FilledPanel fill_panel(const std::vector<Flat>& outline, float edge_mm);

}  // namespace im2fit::body
