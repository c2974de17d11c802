// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/blobs.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace im2fit::segment {
namespace {

constexpr float kFloorBandMm = 35.0F;
constexpr float kFloorBandMaxMm = 70.0F;
constexpr std::uint16_t kFarthestMm = 6500;
constexpr int kSpeckCells = 12;
constexpr float kTorsoMm = 1000.0F;

// Depth noise lifts floor cells by noise x slope of the ray; the band widens with it, up to a shoe's height.
float floor_band_mm(const FloorPlane& floor, float z) {
  return std::min(kFloorBandMaxMm, kFloorBandMm + 0.7F * quantum_mm(z) * floor.camera_height_mm / z);
}

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

BlobFinder::BlobFinder(const Grid& grid)
    : open_(grid.depth.size()),
      part_(grid.depth.size()),
      wall_(grid),
      components_(grid.width, grid.height),
      labels_(grid.depth.size()),
      top_(at(grid.width)),
      planes_(at(kBlobCountMax)) {}

void BlobFinder::describe(const Grid& grid) {
  for (int b = 0; b < blob_count_; ++b) {
    Blob blob;
    blob.c_min = grid.width;
    blob.r_min = grid.height;
    blob.c_max = blob.r_max = -1;
    blob.height_min_mm = 1e9F;
    blob.height_max_mm = -1e9F;
    blobs_[at(b)] = blob;
    planes_[at(b)] = {};
  }
  const float cell_area =
      static_cast<float>(grid.step * grid.step) / (grid.intrinsics.fx * grid.intrinsics.fy) * 1e-6F;
  for (int r = 0; r < grid.height; ++r) {
    const std::uint16_t* labels = labels_.data() + grid.index(0, r);
    const std::uint16_t* depth = grid.depth.data() + grid.index(0, r);
    const float* height = grid.height_mm.data() + grid.index(0, r);
    const float ray_y = grid.ray_y[at(r)];
    for (int c = 0; c < grid.width;) {
      const std::uint16_t label = labels[c];
      if (label == 0) {
        ++c;
        continue;
      }
      // A run of one label at a time, so that its sums stay in registers.
      Blob blob = blobs_[at(label - 1)];
      FloorEquations plane = planes_[at(label - 1)];
      blob.c_min = std::min(blob.c_min, c);
      blob.r_min = std::min(blob.r_min, r);
      blob.r_max = std::max(blob.r_max, r);
      for (; c < grid.width && labels[c] == label; ++c) {
        const float z = static_cast<float>(depth[c]), ray_x = grid.ray_x[at(c)];
        ++blob.cell_count;
        blob.area_m2 += cell_area * z * z;
        blob.height_min_mm = std::min(blob.height_min_mm, height[c]);
        blob.height_max_mm = std::max(blob.height_max_mm, height[c]);
        blob.centroid_mm = blob.centroid_mm + Vec3f{ray_x * z, ray_y * z, z};
        plane.add(ray_x, ray_y, 1.0F / z);
      }
      blob.c_max = std::max(blob.c_max, c - 1);
      blobs_[at(label - 1)] = blob;
      planes_[at(label - 1)] = plane;
    }
  }
  std::array<std::array<double, 3>, kBlobCountMax> q{};
  for (int b = 0; b < blob_count_; ++b) {
    Blob& blob = blobs_[at(b)];
    if (blob.cell_count == 0) continue;
    blob.centroid_mm = blob.centroid_mm * (1.0F / static_cast<float>(blob.cell_count));
    if (!planes_[at(b)].solve_plane(q[at(b)])) q[at(b)] = {0, 0, -1.0 / static_cast<double>(blob.centroid_mm.z)};
  }
  for (int r = 0; r < grid.height; ++r) {
    const std::uint16_t* labels = labels_.data() + grid.index(0, r);
    const std::uint16_t* depth = grid.depth.data() + grid.index(0, r);
    for (int c = 0; c < grid.width;) {
      const std::uint16_t label = labels[c];
      if (label == 0) {
        ++c;
        continue;
      }
      const PlaneRow plane(q[at(label - 1)], grid.ray_y[at(r)]);
      float relief = blobs_[at(label - 1)].relief_mm;
      for (; c < grid.width && labels[c] == label; ++c) {
        const float nearness = plane.nearness(grid.ray_x[at(c)]);
        const float off = static_cast<float>(depth[c]) - 1.0F / nearness;
        const float bounded = nearness > kNearnessMin ? std::clamp(off, -500.0F, 500.0F) : 500.0F;
        relief += bounded * bounded;
      }
      blobs_[at(label - 1)].relief_mm = relief;
    }
  }
  for (int b = 0; b < blob_count_; ++b) {
    Blob& blob = blobs_[at(b)];
    if (blob.cell_count > 0) blob.relief_mm = std::sqrt(blob.relief_mm / static_cast<float>(blob.cell_count));
  }
}

// An arm held across the body cuts the trunk off below it: what lies under a head that ends in the air, at its depth
// and partly behind it, is joined to it.
void BlobFinder::join_trunks(const Grid& grid, const FloorPlane& floor) {
  bool joined = false;
  for (int h = 0; h < head_count_; ++h) {
    const int b = heads_[at(h)].blob;
    const Blob& blob = blobs_[at(b)];
    const bool in_air =
        floor.known ? blob.height_min_mm > kFloatingMm : blob.height_max_mm - blob.height_min_mm < kTorsoMm;
    if (!in_air || blob.r_max >= grid.height - 2) continue;
    const auto label = static_cast<std::uint16_t>(b + 1);
    std::array<std::int16_t, kBlobCountMax> contact{};
    for (int r = blob.r_min; r <= blob.r_max; ++r) {
      for (int c = blob.c_min; c <= blob.c_max; ++c) {
        if (labels_[at(grid.index(c, r))] != label) continue;
        for (int d = 1; d <= 2 && r + d < grid.height; ++d) {
          const std::uint16_t other = labels_[at(grid.index(c, r + d))];
          if (other == label) break;
          if (other != 0) {
            ++contact[at(other - 1)];
            break;
          }
        }
      }
    }
    const Vec3f top = heads_[at(h)].top_mm;
    for (int o = 0; o < blob_count_; ++o) {
      const Blob& other = blobs_[at(o)];
      const Vec3f d = other.centroid_mm - top;
      const bool fits = contact[at(o)] >= 4 && other.area_m2 > 0.05F && std::fabs(d.x) < 350.0F &&
                        std::fabs(d.z) < 350.0F && other.relief_mm > 14.0F + 0.4F * quantum_mm(top.z);
      if (!fits || o == b) continue;
      bool has_head = false;
      for (int i = 0; i < head_count_; ++i) has_head = has_head || heads_[at(i)].blob == o;
      if (has_head) continue;
      for (std::uint16_t& cell : labels_)
        if (cell == static_cast<std::uint16_t>(o + 1)) cell = label;
      joined = true;
    }
  }
  if (joined) describe(grid);
}

void BlobFinder::open_cells(const Grid& grid, const FloorPlane& floor, std::span<const std::uint8_t> background) {
  const std::uint16_t* depth = grid.depth.data();
  const float* height = grid.height_mm.data();
  const std::uint8_t* shown = background.data();
  std::uint8_t* __restrict open = open_.data();
  // The band is nowhere narrower nor wider than these: few cells need it.
  const float low = floor.known ? kFloorBandMm : -std::numeric_limits<float>::infinity();
  const float high = floor.known ? kFloorBandMaxMm : low;
  for (std::size_t i = 0, count = open_.size(); i < count; ++i)
    open[i] =
        static_cast<std::uint8_t>((depth[i] > 0) & (depth[i] < kFarthestMm) & !(height[i] < low) & (shown[i] ^ 1));
  for (std::size_t i = 0, count = open_.size(); i < count; ++i)
    if (height[i] < high && open[i] != 0 && height[i] < floor_band_mm(floor, static_cast<float>(depth[i])))
      open[i] = 0;
}

void BlobFinder::label(const Grid& grid) {
  blob_count_ = components_.run(grid.depth, open_, kSpeckCells, kBlobCountMax, labels_);
  describe(grid);
}

// A person who touches one of a room's further walls is one surface with it: more than a person, and it reaches above
// all heads or out of the picture. From less than that a wall's corner would detach coats on chairs, which resemble
// people.
bool BlobFinder::close_further_walls(const Grid& grid, const FloorPlane& floor) {
  bool closed = false;
  for (int b = 0; b < blob_count_; ++b) {
    const Blob& blob = blobs_[at(b)];
    const bool high = (floor.known && blob.height_max_mm > kHeadHeightMaxMm) || blob.r_min <= 1;
    if (!high || blob.area_m2 < kPersonAreaMaxM2) continue;
    const auto own = static_cast<std::uint16_t>(b + 1);
    for (std::size_t i = 0; i < part_.size(); ++i) part_[i] = labels_[i] == own ? 1 : 0;
    if (!wall_.run(grid, floor, part_)) continue;
    for (std::size_t i = 0; i < open_.size(); ++i)
      if (labels_[i] == own) open_[i] = part_[i];
    closed = true;
  }
  return closed;
}

void BlobFinder::run(const Grid& grid, const FloorPlane& floor, std::span<const std::uint8_t> background,
                     std::span<const Vec3f> expected) {
  open_cells(grid, floor, background);
  wall_.follow(grid, floor, open_);
  label(grid);
  if (close_further_walls(grid, floor)) label(grid);
  head_count_ = 0;
  for (int b = 0; b < blob_count_; ++b) {
    const Blob& blob = blobs_[at(b)];
    if (blob.area_m2 > 0.05F && blob.height_max_mm - blob.height_min_mm > 300.0F) find_heads(grid, b, floor);
  }
  join_trunks(grid, floor);
  expect_heads(grid, floor, expected);
  split_between_heads(grid);
  detach_furniture(grid, floor);
  join_split_bodies(grid, floor);
  judge(grid, floor);
}

}  // namespace im2fit::segment
