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
constexpr float kHigherThanPeopleMm = 2000.0F;

// Depth noise lifts floor cells by noise x slope of the ray; the band widens with it, up to a shoe's height.
float floor_band_mm(const FloorPlane& floor, float z) {
  return std::min(kFloorBandMaxMm, kFloorBandMm + 0.7F * quantum_mm(z) * floor.camera_height_mm / z);
}

void open_cells(const Grid& grid, const FloorPlane& floor, std::span<const std::uint8_t> background, Blobs& found) {
  const std::uint16_t* depth = grid.depth.data();
  const float* height = grid.height_mm.data();
  const std::uint8_t* shown = background.data();
  std::uint8_t* __restrict open = found.open.data();
  // The band is nowhere narrower nor wider than these: few cells need it.
  const float low = floor.known ? kFloorBandMm : -std::numeric_limits<float>::infinity();
  const float high = floor.known ? kFloorBandMaxMm : low;
  for (std::size_t i = 0, count = found.open.size(); i < count; ++i)
    open[i] =
        static_cast<std::uint8_t>((depth[i] > 0) & (depth[i] < kFarthestMm) & !(height[i] < low) & (shown[i] ^ 1));
  for (std::size_t i = 0, count = found.open.size(); i < count; ++i)
    if (height[i] < high && open[i] != 0 && height[i] < floor_band_mm(floor, static_cast<float>(depth[i])))
      open[i] = 0;
}

void label_cells(const Grid& grid, Blobs& found) {
  found.blob_count = found.components.run(grid.depth, found.open, kSpeckCells, kBlobCountMax, found.labels);
  describe_blobs(grid, found);
}

// A person who touches one of a room's further walls is one surface with it: more than a person, and it reaches above
// all heads or out of the picture. From less than that a wall's corner would detach coats on chairs, which resemble
// people.
bool close_further_walls(const Grid& grid, const FloorPlane& floor, Blobs& found) {
  bool closed = false;
  for (int b = 0; b < found.blob_count; ++b) {
    const Blob& blob = found.blobs[at(b)];
    const bool high = (floor.known && blob.height_max_mm > kHeadHeightMaxMm) || blob.r_min <= 1;
    if (!high || blob.area_m2 < kPersonAreaMaxM2) continue;
    const auto own = static_cast<std::uint16_t>(b + 1);
    for (std::size_t i = 0; i < found.part.size(); ++i) found.part[i] = found.labels[i] == own ? 1 : 0;
    if (!found.wall.run(grid, floor, found.part)) continue;
    for (std::size_t i = 0; i < found.open.size(); ++i)
      if (found.labels[i] == own) found.open[i] = found.part[i];
    closed = true;
  }
  return closed;
}

}  // namespace

Blobs::Blobs(const Grid& grid)
    : labels(grid.depth.size()),
      open(grid.depth.size()),
      part(grid.depth.size()),
      labels_before(grid.depth.size()),
      blobs_before(at(kBlobCountMax)),
      heads_before(at(kHeadCountMax)),
      wall(grid),
      components(grid.width, grid.height),
      top(at(grid.width)),
      planes(at(kBlobCountMax)) {}

void describe_blobs(const Grid& grid, Blobs& found) {
  for (int b = 0; b < found.blob_count; ++b) {
    Blob blob;
    blob.c_min = grid.width;
    blob.r_min = grid.height;
    blob.c_max = blob.r_max = -1;
    blob.height_min_mm = 1e9F;
    blob.height_max_mm = -1e9F;
    found.blobs[at(b)] = blob;
    found.planes[at(b)] = {};
  }
  const float cell_area =
      static_cast<float>(grid.step * grid.step) / (grid.intrinsics.fx * grid.intrinsics.fy) * 1e-6F;
  for (int r = 0; r < grid.height; ++r) {
    const std::uint16_t* labels = found.labels.data() + grid.index(0, r);
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
      Blob blob = found.blobs[at(label - 1)];
      FloorEquations plane = found.planes[at(label - 1)];
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
      found.blobs[at(label - 1)] = blob;
      found.planes[at(label - 1)] = plane;
    }
  }
  std::array<std::array<double, 3>, kBlobCountMax> q{};
  for (int b = 0; b < found.blob_count; ++b) {
    Blob& blob = found.blobs[at(b)];
    if (blob.cell_count == 0) continue;
    blob.centroid_mm = blob.centroid_mm * (1.0F / static_cast<float>(blob.cell_count));
    if (!found.planes[at(b)].solve_plane(q[at(b)])) q[at(b)] = {0, 0, -1.0 / static_cast<double>(blob.centroid_mm.z)};
  }
  for (int r = 0; r < grid.height; ++r) {
    const std::uint16_t* labels = found.labels.data() + grid.index(0, r);
    const std::uint16_t* depth = grid.depth.data() + grid.index(0, r);
    for (int c = 0; c < grid.width;) {
      const std::uint16_t label = labels[c];
      if (label == 0) {
        ++c;
        continue;
      }
      const PlaneRow plane(q[at(label - 1)], grid.ray_y[at(r)]);
      float relief = found.blobs[at(label - 1)].relief_mm;
      for (; c < grid.width && labels[c] == label; ++c) {
        const float nearness = plane.nearness(grid.ray_x[at(c)]);
        const float off = static_cast<float>(depth[c]) - 1.0F / nearness;
        const float bounded = nearness > kNearnessMin ? std::clamp(off, -500.0F, 500.0F) : 500.0F;
        relief += bounded * bounded;
      }
      found.blobs[at(label - 1)].relief_mm = relief;
    }
  }
  for (int b = 0; b < found.blob_count; ++b) {
    Blob& blob = found.blobs[at(b)];
    if (blob.cell_count > 0) blob.relief_mm = std::sqrt(blob.relief_mm / static_cast<float>(blob.cell_count));
  }
}

namespace {

void find_people(const Grid& grid, const FloorPlane& floor, std::span<const Vec3f> expected, Blobs& found) {
  found.head_count = 0;
  for (int b = 0; b < found.blob_count; ++b) {
    const Blob& blob = found.blobs[at(b)];
    if (blob.area_m2 > 0.05F && blob.height_max_mm - blob.height_min_mm > 300.0F) find_heads(grid, floor, b, found);
  }
  join_trunks(grid, floor, found);
  expect_heads(grid, floor, expected, found);
  split_between_heads(grid, found);
  detach_furniture(grid, floor, found);
  join_split_bodies(grid, floor, found);
  judge_blobs(grid, floor, found);
}

// Nobody, or someone with what reaches higher than people: a person may be one surface with a wall.
bool joined_with_wall(const Blobs& found) {
  const auto list = found.list();
  const bool none = std::none_of(list.begin(), list.end(), [](const Blob& blob) { return blob.person; });
  return none || std::any_of(list.begin(), list.end(), [](const Blob& blob) {
           return blob.person && (blob.height_max_mm > kHigherThanPeopleMm || blob.r_min == 0);
         });
}

// A cabin's walls are too small for a room's. Without them who touches one stands alone. Furniture without the wall
// behind it resembles people, so only a head counts; else all stays as it was.
void find_people_in_cabin(const Grid& grid, const FloorPlane& floor, std::span<const Vec3f> expected, Blobs& found) {
  if (!floor.known || !found.wall.run_cabin(grid, floor, found.open)) return;
  const int blob_count = found.blob_count, head_count = found.head_count;
  std::copy(found.labels.begin(), found.labels.end(), found.labels_before.begin());
  std::copy_n(found.blobs.begin(), blob_count, found.blobs_before.begin());
  std::copy_n(found.heads.begin(), head_count, found.heads_before.begin());
  label_cells(grid, found);
  find_people(grid, floor, expected, found);
  const auto list = found.list();
  if (std::any_of(list.begin(), list.end(), [](const Blob& blob) { return blob.person && blob.has_head; })) return;
  found.blob_count = blob_count;
  found.head_count = head_count;
  std::copy(found.labels_before.begin(), found.labels_before.end(), found.labels.begin());
  std::copy_n(found.blobs_before.begin(), blob_count, found.blobs.begin());
  std::copy_n(found.heads_before.begin(), head_count, found.heads.begin());
}

}  // namespace

void find_blobs(const Grid& grid, const FloorPlane& floor, std::span<const std::uint8_t> background,
                std::span<const Vec3f> expected, Blobs& found) {
  open_cells(grid, floor, background, found);
  found.wall.follow(grid, floor, found.open);
  label_cells(grid, found);
  if (close_further_walls(grid, floor, found)) label_cells(grid, found);
  find_people(grid, floor, expected, found);
  if (joined_with_wall(found)) find_people_in_cabin(grid, floor, expected, found);
}

}  // namespace im2fit::segment
