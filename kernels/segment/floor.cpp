// SPDX-License-Identifier: Apache-2.0
#include "kernels/segment/floor.h"

#include <algorithm>
#include <cmath>

namespace im2fit::segment {
namespace {

constexpr float kUpXMax = 0.22F;  // roll up to 12 degrees
constexpr float kUpZMax = 0.42F;  // pitch up to 25 degrees
constexpr float kCameraHeightMinMm = 420.0F;
constexpr float kCameraHeightMaxMm = 2500.0F;
constexpr int kHypothesisCount = 120;
constexpr int kScoredCount = 400;
constexpr int kSupportMin = 60;  // cells
constexpr float kSupportWidthMm = 450.0F;
constexpr float kSupportLengthMm = 250.0F;
constexpr float kGateMm = 12.0F;
constexpr float kGateQuanta = 0.8F;
constexpr float kJumpMm = 12.0F;  // the camera was moved

float height_of(const FloorPlane& plane, Vec3f p) {
  return dot(plane.up, p) + plane.camera_height_mm;
}

// Depth noise seen as height: a ray meets the floor at the slope camera_height / z.
float height_gate_mm(const FloorPlane& plane, float z) {
  return kGateMm + kGateQuanta * quantum_mm(1.0F) * z * plane.camera_height_mm;
}

bool plausible(const FloorPlane& plane) {
  return plane.up.y < 0 && std::fabs(plane.up.x) <= kUpXMax && std::fabs(plane.up.z) <= kUpZMax &&
         plane.camera_height_mm >= kCameraHeightMinMm && plane.camera_height_mm <= kCameraHeightMaxMm;
}

bool plane_through(Vec3f a, Vec3f b, Vec3f c, FloorPlane& out) {
  Vec3f n = cross(b - a, c - a);
  const float length = norm(n);
  if (!(length > 1.0e4F)) return false;  // mm^2: three points in a line say nothing
  n = n * (1.0F / length);
  if (n.y > 0) n = -n;
  out.known = true;
  out.up = n;
  out.camera_height_mm = -dot(n, a);
  return plausible(out);
}

}  // namespace

void FloorEquations::add(float rx, float ry, float inverse_z, float w) {
  const double x = rx;
  const double y = ry;
  const double d = w;
  a[0] += d * x * x;
  a[1] += d * x * y;
  a[2] += d * x;
  a[3] += d * y * y;
  a[4] += d * y;
  a[5] += d;
  const double t = -d * static_cast<double>(inverse_z);
  b[0] += t * x;
  b[1] += t * y;
  b[2] += t;
  weight += d;
}

void FloorEquations::add(const FloorRow& row, float ry, float w) {
  const double d = w;
  const double y = ry;
  const double n = row.n;
  const double x = row.x;
  const double t = row.t;
  a[0] += d * static_cast<double>(row.xx);
  a[1] += d * x * y;
  a[2] += d * x;
  a[3] += d * n * y * y;
  a[4] += d * n * y;
  a[5] += d * n;
  b[0] -= d * static_cast<double>(row.tx);
  b[1] -= d * t * y;
  b[2] -= d * t;
  weight += d * n;
}

void FloorEquations::blend(const FloorEquations& older, double share) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += share * older.a[i];
  for (std::size_t i = 0; i < b.size(); ++i) b[i] += share * older.b[i];
  weight += share * older.weight;
}

bool FloorEquations::solve_plane(std::array<double, 3>& q) const {
  const double c00 = a[3] * a[5] - a[4] * a[4];
  const double c01 = a[2] * a[4] - a[1] * a[5];
  const double c02 = a[1] * a[4] - a[2] * a[3];
  const double det = a[0] * c00 + a[1] * c01 + a[2] * c02;
  const double scale = weight * weight * weight;
  if (!(det > 1e-12 * scale)) return false;
  const double c11 = a[0] * a[5] - a[2] * a[2];
  const double c12 = a[1] * a[2] - a[0] * a[4];
  const double c22 = a[0] * a[3] - a[1] * a[1];
  q[0] = (c00 * b[0] + c01 * b[1] + c02 * b[2]) / det;
  q[1] = (c01 * b[0] + c11 * b[1] + c12 * b[2]) / det;
  q[2] = (c02 * b[0] + c12 * b[1] + c22 * b[2]) / det;
  return true;
}

bool FloorEquations::solve(FloorPlane& out) const {
  std::array<double, 3> q{};
  if (!solve_plane(q)) return false;
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
  if (!(length > 1e-6)) return false;
  out.known = true;
  out.up = {static_cast<float>(q[0] / length), static_cast<float>(q[1] / length), static_cast<float>(q[2] / length)};
  out.camera_height_mm = static_cast<float>(1.0 / length);
  return plausible(out);
}

FloorFinder::FloorFinder(const Grid& grid) {
  candidates_.reserve(grid.depth.size());
}

void FloorFinder::reset() {
  tracked_ = {};
  has_gathered_ = false;
}

// A level cell: two cells further up the picture the surface has gone away from the camera, not up.
void FloorFinder::gather(const Grid& grid) {
  candidates_.clear();
  for (int r = 2; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const int here = grid.index(c, r);
      const int above = grid.index(c, r - 2);
      if (grid.depth[static_cast<std::size_t>(here)] == 0 || grid.depth[static_cast<std::size_t>(above)] == 0)
        continue;
      const Vec3f d = grid.point(above) - grid.point(here);
      if (d.z > 0 && std::fabs(d.y) < 0.5F * d.z + 8.0F && d.z < 800.0F) candidates_.push_back(here);
    }
  }
}

FloorPlane FloorFinder::search(const Grid& grid) const {
  FloorPlane best;
  const int count = static_cast<int>(candidates_.size());
  if (count < kSupportMin) return best;
  const auto candidate = [&](int i) { return grid.point(candidates_[static_cast<std::size_t>(i)]); };
  const int stride = std::max(1, count / kScoredCount);
  const int cells = static_cast<int>(grid.depth.size());
  const int cell_stride = std::max(1, cells / kScoredCount) | 1;  // odd: walks all columns
  int best_score = 0;
  std::uint32_t state = 0x2545F491U;
  const auto draw = [&] {
    state = state * 1664525U + 1013904223U;
    return static_cast<int>((static_cast<std::uint64_t>(state) * static_cast<std::uint64_t>(count)) >> 32);
  };
  for (int h = 0; h < kHypothesisCount; ++h) {
    FloorPlane plane;
    const int i = draw();
    const int j = draw();
    const int k = draw();
    if (!plane_through(candidate(i), candidate(j), candidate(k), plane)) continue;
    int score = 0;
    for (int n = 0; n < count; n += stride) {
      const Vec3f p = candidate(n);
      if (std::fabs(height_of(plane, p)) < height_gate_mm(plane, p.z)) ++score;
    }
    if (score <= best_score) continue;
    // Tables are level too; the floor is the level plane with nothing under it.
    for (int n = 0; n < cells; n += cell_stride) {
      if (grid.depth[static_cast<std::size_t>(n)] == 0) continue;
      const Vec3f p = grid.point(n);
      if (height_of(plane, p) < -60.0F - quantum_mm(p.z)) score -= 3;
    }
    if (score <= best_score) continue;
    best_score = score;
    best = plane;
  }
  return best;
}

FloorPlane FloorFinder::fit_cells(const Grid& grid, FloorPlane plane) const {
  for (int pass = 0; pass < 3 && plane.known; ++pass) {
    FloorEquations equations;
    const float share = pass == 0 ? 1.5F : 1.0F;
    for (const std::int32_t cell : candidates_) {
      const Vec3f p = grid.point(cell);
      if (std::fabs(height_of(plane, p)) > share * height_gate_mm(plane, p.z)) continue;
      equations.add(p.x / p.z, p.y / p.z, 1.0F / p.z, 1.0F);
    }
    FloorPlane next;
    if (!equations.solve(next)) return {};
    plane = next;
  }
  return plane;
}

bool FloorFinder::supported(const Grid& grid, const FloorPlane& plane) const {
  if (!plane.known || !plausible(plane)) return false;
  int count = 0;
  float x_min = 1e9F;
  float x_max = -1e9F;
  float z_min = 1e9F;
  float z_max = -1e9F;
  for (const std::int32_t cell : candidates_) {
    const Vec3f p = grid.point(cell);
    if (std::fabs(height_of(plane, p)) > height_gate_mm(plane, p.z)) continue;
    ++count;
    x_min = std::min(x_min, p.x);
    x_max = std::max(x_max, p.x);
    z_min = std::min(z_min, p.z);
    z_max = std::max(z_max, p.z);
  }
  if (count < kSupportMin || x_max - x_min < kSupportWidthMm || z_max - z_min < kSupportLengthMm) return false;
  int below = 0;
  for (std::size_t i = 0; i < grid.depth.size(); ++i) {
    if (grid.depth[i] == 0) continue;
    const Vec3f p = grid.point(static_cast<int>(i));
    if (height_of(plane, p) < -60.0F - quantum_mm(p.z)) ++below;
  }
  return below * 20 <= grid.valid_count && below <= 3 * count;
}

FloorPlane FloorFinder::find(const Grid& grid) {
  gather(grid);
  if (tracked_.known) {
    const FloorPlane followed = fit_cells(grid, tracked_);
    if (supported(grid, followed)) return tracked_ = followed;
  }
  has_gathered_ = false;
  tracked_ = fit_cells(grid, search(grid));
  if (!supported(grid, tracked_)) tracked_ = {};
  return tracked_;
}

FloorPlane FloorFinder::refine(const Grid& grid, DepthView depth, const FloorPlane& coarse, Vec3f feet,
                               std::span<const std::uint8_t> taken) {
  FloorPlane plane = coarse;
  FloorEquations equations;
  const Intrinsics& k = grid.intrinsics;
  const float inverse_fx = 1.0F / k.fx;
  const float inverse_fy = 1.0F / k.fy;
  for (int pass = 0; pass < 2; ++pass) {
    equations = {};
    for (int r = 0; r < grid.height; ++r) {
      for (int c = 0; c < grid.width; ++c) {
        const int cell = grid.index(c, r);
        const auto i = static_cast<std::size_t>(cell);
        if (grid.depth[i] == 0 || taken[i] != 0 || std::fabs(grid.height_mm[i]) > 60.0F) continue;
        const Vec3f p = grid.point(cell);
        const float away_x = p.x - feet.x;
        const float away_z = p.z - feet.z;
        const float away = (away_x * away_x + away_z * away_z) * (1.0F / (500.0F * 500.0F));
        if (away > 25.0F) continue;
        // The first pass only centres the gate; far cells count little: both look at every fourth pixel.
        const int stride = grid.step > 1 && (pass == 0 || away > 2.0F) ? 2 : 1;
        const float weight = static_cast<float>(stride * stride) / (1.0F + away);
        const float gate = pass == 0 ? 1.5F : 1.0F;
        const float gate_flat = gate * kGateMm;
        const float gate_noise = gate * kGateQuanta * quantum_mm(1.0F) * plane.camera_height_mm;
        for (int v = r * grid.step; v < (r + 1) * grid.step; v += stride) {
          const float ry = (static_cast<float>(v) - k.cy) * inverse_fy;
          const float row = plane.up.y * ry + plane.up.z;
          FloorRow sums;
          for (int u = c * grid.step; u < (c + 1) * grid.step; u += stride) {
            const std::uint16_t raw = depth.at(u, v);
            if (raw == 0 || raw > kDepthMaxMm) continue;
            const float z = static_cast<float>(raw);
            const float rx = (static_cast<float>(u) - k.cx) * inverse_fx;
            const float height = (plane.up.x * rx + row) * z + plane.camera_height_mm;
            if (std::fabs(height) > gate_flat + gate_noise * z) continue;
            sums.add(rx, 1.0F / z);
          }
          equations.add(sums, ry, weight);
        }
      }
    }
    FloorPlane next;
    if (equations.weight < 30.0 || !equations.solve(next)) return coarse;
    plane = next;
  }
  if (has_gathered_) {
    FloorPlane before;
    if (gathered_.solve(before) && std::fabs(height_of(before, feet) - height_of(plane, feet)) < kJumpMm) {
      equations.blend(gathered_, 0.85);  // about seven frames' worth
      if (!equations.solve(plane)) return coarse;
    }
  }
  gathered_ = equations;
  has_gathered_ = true;
  return tracked_ = plane;
}

}  // namespace im2fit::segment
