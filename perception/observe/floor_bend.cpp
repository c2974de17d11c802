// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/floor_bend.h"

#include <algorithm>
#include <array>
#include <cmath>

// The thresholds of this file. Sources:
//   [floor] as in segment/floor.cpp
//   [rooms] chosen on synthetic rooms, 2026-11-30: of 300 of them the bend is within 0.02 of the truth
namespace im2fit::floor_bend_limits {

constexpr int kBendAcross = 160;          // pixels read along the picture's long side; [rooms]
constexpr int kRaysMin = 300;             // fewer are no floor to judge; [rooms]
constexpr float kFloorDepthMaxMm = 6000;  // beyond, noise outweighs the bend; [rooms]
constexpr float kFloorSlope = 0.5F;       // rise over run of level pixels, most; [floor]
constexpr float kFloorRiseMm = 8;         // and so much rise; [floor]
constexpr float kFloorRunMaxMm = 800;     // run, most; [floor]
constexpr double kPivotMin = 1e-9;        // of the equations, a ray: less spans no surface, and is far above rounding
// From the surface, pass by pass: first from the plane as found, which holds only a part of a bowl; [rooms]
constexpr std::array<float, 5> kBendGatesMm = {160, 80, 40, 25, 25};

}  // namespace im2fit::floor_bend_limits

namespace im2fit {

using namespace floor_bend_limits;

namespace {

constexpr std::size_t kBendUnknowns = 4;
using BendRow = std::array<double, kBendUnknowns>;

// The upper triangle of the normal matrix, and the right side.
struct BendEquations {
  std::array<BendRow, kBendUnknowns> a{};
  BendRow b{};
  int count = 0;

  void add(const BendRow& row, double right) {
    for (std::size_t i = 0; i < kBendUnknowns; ++i) {
      for (std::size_t j = i; j < kBendUnknowns; ++j) a[i][j] += row[i] * row[j];
      b[i] += row[i] * right;
    }
    ++count;
  }
  // By elimination; the matrix is symmetric and positive where the rays span a surface.
  bool solve(BendRow& x) {
    for (std::size_t i = 0; i < kBendUnknowns; ++i)
      for (std::size_t j = 0; j < i; ++j) a[i][j] = a[j][i];
    for (std::size_t i = 0; i < kBendUnknowns; ++i) {
      const double pivot = a[i][i];
      if (!(pivot > kPivotMin * count)) return false;
      for (std::size_t r = i + 1; r < kBendUnknowns; ++r) {
        const double share = a[r][i] / pivot;
        for (std::size_t c = i; c < kBendUnknowns; ++c) a[r][c] -= share * a[i][c];
        b[r] -= share * b[i];
      }
    }
    for (std::size_t i = kBendUnknowns; i-- > 0;) {
      double sum = b[i];
      for (std::size_t c = i + 1; c < kBendUnknowns; ++c) sum -= a[i][c] * x[c];
      x[i] = sum / a[i][i];
    }
    return true;
  }
};

}  // namespace

FloorBendFitter::FloorBendFitter(int width, int height)
    : step_(std::max(1, (std::max(width, height) + kBendAcross / 2) / kBendAcross)) {
  rays_.reserve(static_cast<std::size_t>(width / step_ + 1) * static_cast<std::size_t>(height / step_ + 1));
}

// Level pixels near the plane: two steps further up the picture the surface has gone away from the camera, not up.
void FloorBendFitter::collect(DepthView depth, MaskView mask, const Intrinsics& k, const FloorPlane& floor) {
  rays_.clear();
  for (int v = 2 * step_; v < depth.height; v += step_) {
    const float ry = (static_cast<float>(v) - k.cy) / k.fy;
    const float above_ry = (static_cast<float>(v - 2 * step_) - k.cy) / k.fy;
    for (int u = 0; u < depth.width; u += step_) {
      const float z = static_cast<float>(depth.at(u, v)), above_z = static_cast<float>(depth.at(u, v - 2 * step_));
      if (mask.at(u, v) != 0 || !(z > 0 && z < kFloorDepthMaxMm && above_z > 0)) continue;
      const float dz = above_z - z, dy = above_ry * above_z - ry * z;
      if (!(dz > 0 && dz < kFloorRunMaxMm && std::fabs(dy) < kFloorSlope * dz + kFloorRiseMm)) continue;
      const float rx = (static_cast<float>(u) - k.cx) / k.fx;
      const float height = dot(floor.up, {rx * z, ry * z, z}) + floor.camera_height_mm;
      if (std::fabs(height) < kBendGatesMm[0]) rays_.push_back({rx, ry, 1 / z});
    }
  }
}

FloorBend FloorBendFitter::run(DepthView depth, MaskView mask, const Intrinsics& k, const FloorPlane& floor) {
  collect(depth, mask, k, floor);
  // Times the camera's height, so that all unknowns are near 1: up.r + bend |r|^2 n = -n, n the camera's height over
  // z.
  BendRow q = {static_cast<double>(floor.up.x), static_cast<double>(floor.up.y), static_cast<double>(floor.up.z), 0};
  const auto camera_mm = static_cast<double>(floor.camera_height_mm);
  for (const float gate_mm : kBendGatesMm) {
    BendEquations equations;
    for (const Ray& ray : rays_) {
      const auto x = static_cast<double>(ray.x), y = static_cast<double>(ray.y);
      const double n = static_cast<double>(ray.inverse_z) * camera_mm;
      const double bowl = x * x + y * y, plane = q[0] * x + q[1] * y + q[2];
      const double off = plane + q[3] * bowl * n + n;
      // The n of the surface before, not the measured one: with its noise on both sides of the equation, and in the
      // gate, that bends a floor of which little is seen.
      const double smooth_n = -plane / (1 + q[3] * bowl);
      // As a height.
      if (std::fabs(off) * camera_mm < static_cast<double>(gate_mm) * smooth_n)
        equations.add({x, y, 1, bowl * smooth_n}, -n);
    }
    if (equations.count < kRaysMin || !equations.solve(q)) return {};
  }
  return {true, static_cast<float>(q[3])};
}

}  // namespace im2fit
