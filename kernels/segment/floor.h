// SPDX-License-Identifier: Apache-2.0
// The floor plane. In inverse depth a plane is linear in the pixel: with q = up / camera_height and the pixel's ray
// r = (x/z, y/z, 1), every floor point has q.r = -1/z, and the sensor's disparity noise is even over the picture.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/floor_sums/floor_sums.h"
#include "kernels/segment/grid.h"

namespace im2fit::segment {

// Depth at which a ray meets the plane q.r = -1/z; 0 when it does not.
inline float plane_depth(const std::array<double, 3>& q, float rx, float ry) {
  const float inverse = -(static_cast<float>(q[0]) * rx + static_cast<float>(q[1]) * ry + static_cast<float>(q[2]));
  return inverse > 1e-5F ? 1.0F / inverse : 0.0F;
}

// Upper triangle of the 3x3 normal matrix, right side, and the sum of weights.
struct FloorEquations {
  std::array<double, 6> a{};
  std::array<double, 3> b{};
  double weight = 0;

  FloorEquations() = default;
  explicit FloorEquations(const PlaneSums& sums)
      : a(std::to_array(sums.a)), b(std::to_array(sums.b)), weight(sums.weight) {}
  // A point of weight 1.
  void add(float rx, float ry, float inverse_z) {
    const double x = rx, y = ry, t = inverse_z;
    a[0] += x * x;
    a[1] += x * y;
    a[2] += x;
    a[3] += y * y;
    a[4] += y;
    a[5] += 1;
    b[0] -= t * x;
    b[1] -= t * y;
    b[2] -= t;
    weight += 1;
  }
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
  // A cell that looks level.
  struct Candidate {
    Vec3f point;
    float ray_x = 0, ray_y = 0, inverse_z = 0;
  };

  void gather(const Grid& grid, float slope);  // rise over run in the picture's axes
  FloorPlane search(const Grid& grid, float up_z_max) const;
  bool supported(const Grid& grid, const FloorPlane& plane) const;
  FloorPlane fit_cells(FloorPlane plane) const;
  int list_cells(const Grid& grid, Vec3f feet, std::span<const std::uint8_t> taken, int pass);
  std::span<const Candidate> candidates() const {
    return {candidates_.data(), static_cast<std::size_t>(candidate_count_)};
  }

  std::vector<Candidate> candidates_;
  int candidate_count_ = 0;
  std::vector<std::uint8_t> level_;  // of a row of cells
  std::vector<FloorCell> near_cells_;
  std::vector<float> pixel_ray_x_, pixel_ray_y_, row_up_;
  FloorPlane tracked_;
  FloorEquations gathered_;
  bool has_gathered_ = false;
};

}  // namespace im2fit::segment
