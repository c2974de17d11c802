// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/wall.h"

#include <algorithm>
#include <cmath>

#include "perception/segment/floor.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [rooms] chosen on synthetic rooms, no measurement on record
namespace im2fit::segment::wall_limits {

constexpr int kOpenCountMin = 400;          // cells not yet anything's, least, to search for a wall; [rooms]
constexpr int kHypothesisCount = 60;        // planes tried; [rooms]
constexpr int kScoredCount = 400;           // cells that vote on each; [rooms]
constexpr float kWidthMinMm = 1300.0F;      // along the floor, least; [rooms]
constexpr float kAreaMinM2 = 1.2F;          // least: more than a person with both arms out; [rooms]
constexpr int kCabinWalls = 3;              // left, behind and right; [rooms]
constexpr float kCabinWidthMinMm = 600.0F;  // of each along the floor, least; [rooms]
constexpr float kCabinAreaMinM2 = 0.35F;    // least; [rooms]
constexpr float kCabinHighMm = 2000.0F;     // above the floor: higher than people; [rooms]
constexpr int kCabinTopRows = 2;            // of the picture; [rooms]
constexpr int kCabinHighCells = 20;         // of each there or at the picture's top, least; [rooms]
constexpr float kOnMm = 20.0F;              // off the wall, with a disparity step: still of it; [rooms]
constexpr float kBehindMm = 45.0F;          // before the wall, with two disparity steps: goes with it; [rooms]
// A wall found before is looked for anew when one in so many of its votes is lost. Noise of 400 votes is 2.5 % at
// most (of a wall that has a half of them; binomial); [rooms]
constexpr int kFollowParts = 10;
constexpr float kUprightMax = 0.25F;      // sine of a wall's tilt, most; [rooms]
constexpr float kDistanceMinMm = 300.0F;  // of its plane from the camera, least; [rooms]

}  // namespace im2fit::segment::wall_limits

namespace im2fit::segment {

using namespace wall_limits;

namespace {

int vote_stride(std::size_t cells) {
  return std::max(1, static_cast<int>(cells) / kScoredCount) | 1;  // odd: walks all columns
}

int count_open(std::span<const std::uint8_t> open) {
  int count = 0;
  for (const std::uint8_t o : open) count += o;
  return count;
}

}  // namespace

Votes count_votes(const VotingPoints& points, const float* q) {
  const float q0 = q[0], q1 = q[1], q2 = q[2];
  int on = 0, behind = 0;
  for (int i = 0; i < points.count; ++i) {
    const float inverse = -(q0 * points.ray_x[i] + q1 * points.ray_y[i] + q2);
    const float plane = 1.0F / inverse, z = points.z_mm[i];
    const bool meets = inverse > 1e-5F;
    on += static_cast<int>(meets) & static_cast<int>(std::fabs(z - plane) < points.near_mm[i]);
    behind += static_cast<int>(meets) & static_cast<int>(z > plane + 80.0F + points.far_mm[i]);
  }
  return {on, behind};
}

WallRemover::WallRemover(const Grid& grid) : on_(at(grid.width)) {
  const auto stride = static_cast<std::size_t>(vote_stride(grid.depth.size()));
  const std::size_t voters = (grid.depth.size() + stride - 1) / stride;
  for (std::vector<float>* v : {&ray_x_, &ray_y_, &z_mm_, &near_mm_, &far_mm_}) v->resize(voters);
  for (std::vector<float>* v : {&row_on_.ray_x, &row_on_.z_mm, &row_on_.inverse_z}) v->resize(on_.size());
}

void WallRemover::collect_voters(const Grid& grid, std::span<const std::uint8_t> open) {
  const int stride = vote_stride(open.size());
  voter_count_ = 0;
  for (int cell = 0; cell < static_cast<int>(open.size()); cell += stride) {
    if (open[at(cell)] == 0) continue;
    const std::size_t i = at(voter_count_++);
    const float z = static_cast<float>(grid.depth[at(cell)]);
    ray_x_[i] = grid.ray_x[at(cell % grid.width)];
    ray_y_[i] = grid.ray_y[at(cell / grid.width)];
    z_mm_[i] = z;
    near_mm_[i] = kOnMm + quantum_mm(z);
    far_mm_[i] = 2.0F * quantum_mm(z);
  }
}

Votes WallRemover::vote(const Plane& plane) const {
  const VotingPoints voters = {ray_x_.data(),   ray_y_.data(),  z_mm_.data(),
                               near_mm_.data(), far_mm_.data(), voter_count_};
  const std::array<float, 3> q = {static_cast<float>(plane[0]), static_cast<float>(plane[1]),
                                  static_cast<float>(plane[2])};
  return count_votes(voters, q.data());
}

bool WallRemover::search(const Grid& grid, Vec3f up, std::span<const std::uint8_t> open, Plane& best) {
  const auto cells = static_cast<std::uint64_t>(open.size());
  std::uint32_t state = 0x9E3779B9U;
  const auto draw = [&] {
    for (int tries = 0; tries < 32; ++tries) {
      state = state * 1664525U + 1013904223U;
      const int i = static_cast<int>((static_cast<std::uint64_t>(state) * cells) >> 32);
      if (open[at(i)] != 0) return i;
    }
    return -1;
  };
  int best_support = 0;
  for (int h = 0; h < kHypothesisCount; ++h) {
    const int i = draw();
    const int j = draw();
    const int k = draw();
    if (i < 0 || j < 0 || k < 0) continue;
    const Vec3f a = grid.point(i);
    Vec3f n = cross(grid.point(j) - a, grid.point(k) - a);
    const float length = norm(n);
    if (!(length > 4.0e4F)) continue;
    n = n * (1.0F / length);
    const float offset = -dot(n, a);
    if (std::fabs(dot(n, up)) > kUprightMax || std::fabs(offset) < kDistanceMinMm) continue;
    const Plane plane = {static_cast<double>(n.x / offset), static_cast<double>(n.y / offset),
                         static_cast<double>(n.z / offset)};
    const Votes count = vote(plane);
    if (count.on * 6 < voter_count_ || count.behind * 16 > voter_count_ || count.on <= best_support) continue;
    best_support = count.on;
    best = plane;
  }
  return best_support > 0;
}

void WallRemover::collect_on(const Grid& grid, std::span<const std::uint8_t> open, const Plane& plane, int row) {
  const std::uint16_t* depth = grid.depth.data() + grid.index(0, row);
  const std::uint8_t* is_open = open.data() + grid.index(0, row);
  const float* ray_x = grid.ray_x.data();
  const PlaneRow wall(plane, grid.ray_y[at(row)]);
  std::uint8_t* __restrict on = on_.data();
  const std::size_t width = on_.size();
  for (std::size_t c = 0; c < width; ++c) {
    const float z = static_cast<float>(depth[c]);
    const float nearness = wall.nearness(ray_x[c]);
    const bool near = std::fabs(z - 1.0F / nearness) <= kOnMm + quantum_mm(z);
    on[c] = static_cast<std::uint8_t>((nearness > kNearnessMin) & near & (is_open[c] != 0));
  }
  float *x = row_on_.ray_x.data(), *z = row_on_.z_mm.data(), *inverse = row_on_.inverse_z.data();
  std::size_t count = 0;
  for (std::size_t c = 0; c < width; ++c) {
    if (c % kTogether == 0 && c + kTogether <= width && none(on + c)) {
      c += kTogether - 1;
      continue;
    }
    x[count] = ray_x[c];
    z[count] = static_cast<float>(depth[c]);
    count += on[c];
  }
  for (std::size_t i = 0; i < count; ++i) inverse[i] = 1.0F / z[i];
  row_on_.count = count;
}

// Fits the plane to all cells on it; false when they are too few.
bool WallRemover::refine(const Grid& grid, std::span<const std::uint8_t> open, Plane& plane, Extent& extent) {
  float x_min = 1e9F;
  float x_max = -1e9F;
  float z_min = 1e9F;
  float z_max = -1e9F;
  float area_m2 = 0;
  const float cell_area =
      static_cast<float>(grid.step * grid.step) / (grid.intrinsics.fx * grid.intrinsics.fy) * 1e-6F;
  for (int pass = 0; pass < 2; ++pass) {
    PointSums sums;
    area_m2 = 0;
    for (int r = 0; r < grid.height; ++r) {
      collect_on(grid, open, plane, r);
      const float ray_y = grid.ray_y[at(r)];
      for (std::size_t i = 0; i < row_on_.count; ++i) {
        const float ray_x = row_on_.ray_x[i], z = row_on_.z_mm[i], x = ray_x * z;
        sums.add(ray_x, ray_y, row_on_.inverse_z[i]);
        x_min = std::min(x_min, x);
        x_max = std::max(x_max, x);
        z_min = std::min(z_min, z);
        z_max = std::max(z_max, z);
        area_m2 += cell_area * z * z;
      }
    }
    const FloorEquations equations = sums.equations();
    if (equations.weight < 100.0 || !equations.solve_plane(plane)) return false;
  }
  const float across = x_max - x_min;
  const float along = z_max - z_min;
  extent.width2_mm2 = across * across + along * along;
  extent.area_m2 = area_m2;
  return true;
}

bool WallRemover::find(const Grid& grid, Vec3f up, std::span<const std::uint8_t> open, Plane& plane) {
  collect_voters(grid, open);
  Extent extent;
  return search(grid, up, open, plane) && refine(grid, open, plane, extent) &&
         extent.width2_mm2 >= kWidthMinMm * kWidthMinMm && extent.area_m2 >= kAreaMinM2;
}

// Cells on the plane that are higher than people, or where the picture ends above.
int WallRemover::count_high(const Grid& grid, const Plane& plane, std::span<const std::uint8_t> open) {
  int count = 0;
  for (int r = 0; r < grid.height; ++r) {
    const PlaneRow wall(plane, grid.ray_y[at(r)]);
    for (int c = 0; c < grid.width; ++c) {
      const auto i = at(grid.index(c, r));
      if (open[i] == 0 || (r >= kCabinTopRows && grid.height_mm[i] < kCabinHighMm)) continue;
      const float z = static_cast<float>(grid.depth[i]);
      const float nearness = wall.nearness(grid.ray_x[at(c)]);
      const bool on = nearness > kNearnessMin && std::fabs(z - 1.0F / nearness) <= kOnMm + quantum_mm(z);
      count += on ? 1 : 0;
    }
  }
  return count;
}

bool WallRemover::run_cabin(const Grid& grid, const FloorPlane& floor, std::span<std::uint8_t> open) {
  if (!floor.known) return false;
  int count = 0;
  for (; count < kCabinWalls; ++count) {
    if (count_open(open) < kOpenCountMin) break;
    collect_voters(grid, open);
    Plane plane{};
    Extent extent;
    if (!search(grid, floor.up, open, plane) || !refine(grid, open, plane, extent)) break;
    if (extent.width2_mm2 < kCabinWidthMinMm * kCabinWidthMinMm || extent.area_m2 < kCabinAreaMinM2 ||
        count_high(grid, plane, open) < kCabinHighCells)
      break;
    close(grid, plane, open);
  }
  return count > 0;
}

void WallRemover::close(const Grid& grid, const Plane& plane, std::span<std::uint8_t> open) {
  for (int r = 0; r < grid.height; ++r) {
    const std::uint16_t* depth = grid.depth.data() + grid.index(0, r);
    std::uint8_t* __restrict is_open = open.data() + grid.index(0, r);
    const float* ray_x = grid.ray_x.data();
    const PlaneRow wall(plane, grid.ray_y[at(r)]);
    for (int c = 0, width = grid.width; c < width; ++c) {
      const float z = static_cast<float>(depth[c]);
      const float nearness = wall.nearness(ray_x[c]);
      const bool behind = z > 1.0F / nearness - kBehindMm - 2.0F * quantum_mm(z);
      is_open[c] = static_cast<std::uint8_t>(is_open[c] & !((nearness > kNearnessMin) & behind));
    }
  }
}

bool WallRemover::run(const Grid& grid, const FloorPlane& floor, std::span<std::uint8_t> open) {
  Plane plane{};
  if (count_open(open) < kOpenCountMin || !find(grid, floor.up, open, plane)) return false;
  close(grid, plane, open);
  return true;
}

bool WallRemover::follow(const Grid& grid, const FloorPlane& floor, std::span<std::uint8_t> open) {
  if (count_open(open) < kOpenCountMin) {
    followed_.reset();
    return false;
  }
  if (followed_) {
    collect_voters(grid, open);
    const Votes now = vote(followed_->plane);
    // The share of the voters, since what stands before the wall comes and goes.
    const auto share = [](int count, int of, int others) { return std::int64_t{count} * of * others; };
    const bool stands =
        share(now.on, followed_->voters, kFollowParts) >= share(followed_->on, voter_count_, kFollowParts - 1) &&
        now.behind * 16 <= voter_count_;
    if (!stands) followed_.reset();
  }
  if (!followed_) {
    Plane plane{};
    if (!find(grid, floor.up, open, plane)) return false;
    followed_ = {plane, vote(plane).on, voter_count_};
  }
  close(grid, followed_->plane, open);
  return true;
}

}  // namespace im2fit::segment
