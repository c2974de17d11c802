// SPDX-License-Identifier: Apache-2.0
// The floor plane. In inverse depth a plane is linear in the pixel: with q = up / camera_height and the pixel's ray
// r = (x/z, y/z, 1), every floor point has q.r = -1/z, and the sensor's disparity noise is even over the picture.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/segment/grid.h"

namespace im2fit::segment {

// A few neighbouring pixels of one row, summed in float: their range is small enough.
struct FloorRow {
  float n = 0, x = 0, xx = 0, t = 0, tx = 0;
  void add(float rx, float inverse_z) {
    n += 1.0F;
    x += rx;
    xx += rx * rx;
    t += inverse_z;
    tx += inverse_z * rx;
  }
};

// Upper triangle of the 3x3 normal matrix, right side, and the sum of weights.
struct FloorEquations {
  std::array<double, 6> a{};
  std::array<double, 3> b{};
  double weight = 0;
  void add(float rx, float ry, float inverse_z, float w);
  void add(const FloorRow& row, float ry, float w);
  void blend(const FloorEquations& older, double share);
  // q with q.r = -1/z in the least-squares sense; false when the points do not span a plane.
  bool solve_plane(std::array<double, 3>& q) const;
  // The same as a floor; false also when it is no floor (roll, pitch, camera height).
  bool solve(FloorPlane& out) const;
};

class FloorFinder {
 public:
  explicit FloorFinder(const Grid& grid);
  void reset();
  // Plane of this frame: the tracked one when still supported, else searched for. Unknown when nothing supports it.
  FloorPlane find(const Grid& grid);
  // Precise fit on the pixels of floor cells, those near `feet` counting most; cells with `taken` != 0 are left out.
  // Averages over the frames since the last reset or jump.
  FloorPlane refine(const Grid& grid, DepthView depth, const FloorPlane& coarse, Vec3f feet,
                    std::span<const std::uint8_t> taken);

 private:
  void gather(const Grid& grid);
  FloorPlane search(const Grid& grid) const;
  bool supported(const Grid& grid, const FloorPlane& plane) const;
  FloorPlane fit_cells(const Grid& grid, FloorPlane plane) const;

  std::vector<std::int32_t> candidates_;  // cells that look level
  FloorPlane tracked_;
  FloorEquations gathered_;
  bool has_gathered_ = false;
};

}  // namespace im2fit::segment
