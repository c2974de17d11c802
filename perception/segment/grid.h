// SPDX-License-Identifier: Apache-2.0
// The coarse picture segmentation thinks on: cells of step x step pixels, about 160 cells on the long side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/camera.h"
#include "core/floor_plane.h"

namespace im2fit::segment {

inline constexpr std::uint16_t kDepthMaxMm = 10000;  // range limit of structured light; larger: missing

// Depth step of one disparity unit, mm (Khoshelham 2012: 2.85e-5 z^2 cm, z in cm).
inline float quantum_mm(float z_mm) {
  return 2.85e-6F * z_mm * z_mm;
}
// Neighbours further apart in depth than this are different things.
inline float depth_step_mm(float z_mm) {
  return 40.0F + 1.5F * quantum_mm(z_mm);
}

// Of kTogether flags or labels in a row, whether none is set: most of a picture is nothing's.
inline constexpr std::size_t kTogether = 8;
inline bool none(const std::uint8_t* flags) {
  std::uint64_t all = 0;
  std::memcpy(&all, flags, kTogether);
  return all == 0;
}

// An index into a row, a column or the cells of a picture.
constexpr std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

struct Grid {
  Grid(int image_width, int image_height);
  // Depth of each cell: the lower median of up to five of its pixels.
  void sample(DepthView depth, const Intrinsics& intrinsics);
  // Height of each cell above the floor, or above the camera (up = -y) when none is known.
  void measure_heights(const FloorPlane& floor);

  int index(int cell_u, int cell_v) const { return cell_v * width + cell_u; }
  Vec3f point(int cell_u, int cell_v) const {
    const float z = static_cast<float>(depth[at(index(cell_u, cell_v))]);
    return {ray_x[at(cell_u)] * z, ray_y[at(cell_v)] * z, z};
  }
  // Divides twice: not for loops over all cells.
  Vec3f point(int cell) const { return point(cell % width, cell / width); }

  int step;  // px
  int width;
  int height;
  int valid_count = 0;
  Intrinsics intrinsics;
  std::vector<std::uint16_t> depth;  // mm, 0 = no data
  std::vector<float> height_mm;
  std::vector<float> ray_x;  // x/z of a column's centre
  std::vector<float> ray_y;  // y/z of a row's centre
};

// Width of a cell at a distance.
inline float cell_mm(const Grid& grid, float z_mm) {
  return static_cast<float>(grid.step) * z_mm / grid.intrinsics.fx;
}

}  // namespace im2fit::segment
