// SPDX-License-Identifier: Apache-2.0
// The floor plane. In inverse depth a plane is linear in the pixel: with q = up / camera_height and the pixel's ray
// r = (x/z, y/z, 1), every floor point has q.r = -1/z, and the sensor's disparity noise is even over the picture.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernels/floor_sums/floor_sums.h"
#include "perception/segment/grid.h"

namespace im2fit::segment {

// 1/z at which the rays of a row of the picture meet the plane q.r = -1/z; they do above kNearnessMin.
struct PlaneRow {
  PlaneRow(const std::array<double, 3>& q, float ray_y)
      : q_x(static_cast<float>(q[0])), q_y_ry(static_cast<float>(q[1]) * ray_y), q_z(static_cast<float>(q[2])) {}
  float nearness(float ray_x) const { return -(q_x * ray_x + q_y_ry + q_z); }
  float q_x, q_y_ry, q_z;
};
inline constexpr float kNearnessMin = 1e-5F;

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
  // The same plane as a floor; false also when it is not a plausible floor (roll, pitch, camera height).
  bool solve(FloorPlane& out) const;
};

// FloorEquations of many points of weight 1: few enough sums to stay in registers.
class PointSums {
 public:
  void add(float rx, float ry, float inverse_z) {
    const double x = rx, y = ry, t = inverse_z;
    xx_ += x * x;
    xy_ += x * y;
    x_ += x;
    yy_ += y * y;
    y_ += y;
    tx_ -= t * x;
    ty_ -= t * y;
    t_ -= t;
    ++count_;
  }
  FloorEquations equations() const {
    FloorEquations out;
    out.weight = count_;
    out.a = {xx_, xy_, x_, yy_, y_, out.weight};
    out.b = {tx_, ty_, t_};
    return out;
  }

 private:
  double xx_ = 0, xy_ = 0, x_ = 0, yy_ = 0, y_ = 0, tx_ = 0, ty_ = 0, t_ = 0;
  int count_ = 0;
};

class FloorFinder {
 public:
  explicit FloorFinder(const Grid& grid);
  void reset();
  // Plane of this frame: the one of the frame before as long as as many cells lie on it; else that one fitted to this
  // frame's cells when still supported, else searched for. Unknown when nothing supports it.
  // With `up`, against gravity, no plane that is not level; of an unknown floor it is the plane's up.
  FloorPlane find(const Grid& grid, const std::optional<Vec3f>& up = std::nullopt);
  // Precise fit on the pixels of floor cells, those near `feet` counting most; cells with `taken` != 0 are left out.
  // Averages over the frames since the last reset or jump: of a plane that find() kept from the frame before a part
  // of the cells a frame is enough.
  FloorPlane refine(const Grid& grid, DepthView depth, const FloorPlane& coarse, Vec3f feet,
                    std::span<const std::uint8_t> taken);

 private:
  // The cells that are level, the first `count` of each.
  struct Candidates {
    std::vector<float> x, y, z;  // mm
    std::vector<float> ray_x, ray_y, inverse_z;
    std::vector<std::uint8_t> on;  // 1: on the plane last queried
    std::size_t count = 0;
    Vec3f point(std::size_t i) const { return {x[i], y[i], z[i]}; }
  };

  void collect_level_cells(const Grid& grid, float slope);  // rise over run in the picture's axes
  void mark_on(const FloorPlane& plane, float share);
  FloorPlane follow_or_search(const Grid& grid);
  FloorPlane search(const Grid& grid, float up_z_max) const;
  bool level(const FloorPlane& plane) const;
  bool supported(const Grid& grid, const FloorPlane& plane);
  bool still_there(const Grid& grid);
  FloorPlane fitted(const FloorPlane& plane);
  FloorPlane fit_cells(FloorPlane plane);
  // Rows first_row, first_row + row_step, ...
  int list_cells(const Grid& grid, const FloorPlane& plane, Vec3f feet, std::span<const std::uint8_t> taken,
                 int first_row = 0, int row_step = 1);
  void list_more_pixels(const Grid& grid, int count);
  bool fit_pixels(const Grid& grid, DepthView depth, float gate_share, int count, FloorPlane& plane,
                  FloorEquations& equations);
  bool refine_part(const Grid& grid, DepthView depth, Vec3f feet, std::span<const std::uint8_t> taken,
                   FloorPlane& plane, FloorEquations& equations);
  bool refine_whole(const Grid& grid, DepthView depth, Vec3f feet, std::span<const std::uint8_t> taken,
                    FloorPlane& plane, FloorEquations& equations);
  bool near_accumulated(const FloorPlane& plane, Vec3f feet) const;

  Candidates candidates_;
  std::vector<std::uint8_t> level_;  // of a row of cells
  std::vector<FloorCell> near_cells_;
  std::vector<float> away_;  // of those: their squared distance from the feet, in units of its weight's
  std::vector<float> pixel_ray_x_, pixel_ray_y_, row_up_;
  FloorPlane tracked_;
  int on_count_ = 0;         // cells on a plane, of the last supported()
  int fitted_on_count_ = 0;  // on tracked_, when its cells were last fitted
  bool kept_ = false;        // tracked_ is of the frame before
  int part_ = 0;             // of kRefineParts, refined next
  std::optional<Vec3f> up_;  // of the frame at work
  FloorEquations accumulated_;
  bool has_accumulated_ = false;
  int accumulated_count_ = 0;  // frames, at most kWholeFrames
};

}  // namespace im2fit::segment
