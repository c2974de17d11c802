// SPDX-License-Identifier: Apache-2.0
// A wall is a wide upright plane with next to nothing behind it. Removing it first keeps whatever leans on it apart.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/floor_plane.h"
#include "perception/segment/grid.h"

namespace im2fit::segment {

struct Votes {
  int on = 0;      // within near_mm in depth
  int behind = 0;  // farther than the plane + 80 mm + far_mm
};

// Points by ray (x/z, y/z) and depth, with their own limits; arrays of `count`.
struct VotingPoints {
  const float *ray_x, *ray_y, *z_mm, *near_mm, *far_mm;
  int count;
};

// How many points lie on a plane and how many behind it: the score of one guess in a search for a wall. The plane is
// q . (x/z, y/z, 1) = -1/z; rays that meet it beyond 100 m, or not at all, do not vote. Float, in this order:
// inverse = -((q0 x + q1 y) + q2), plane = 1 / inverse, |z - plane| < near, z > (plane + 80) + far. No allocation,
// thread-safe.
Votes count_votes(const VotingPoints& points, const float* q);

class WallRemover {
 public:
  explicit WallRemover(const Grid& grid);
  // Closes the cells (`open` 1 to 0) of a wall and of everything behind it; false: no wall was found.
  bool run(const Grid& grid, const FloorPlane& floor, std::span<std::uint8_t> open);
  // The same for the walls of a cabin, each smaller than a room's, which reach higher than people; three at most.
  bool run_cabin(const Grid& grid, const FloorPlane& floor, std::span<std::uint8_t> open);
  // The same for a room's main wall, frame after frame: the plane of the frame before is kept as long as the cells
  // that vote on walls confirm it. Depends on the frames alone.
  bool follow(const Grid& grid, const FloorPlane& floor, std::span<std::uint8_t> open);
  void reset() { followed_.reset(); }

 private:
  using Plane = std::array<double, 3>;  // q of q.r = -1/z

  struct Followed {
    Plane plane{};
    int on = 0, voters = 0;  // when it was fitted
  };

  Votes vote(const Plane& plane) const;
  // Of the cells on a plane.
  struct Extent {
    float width2_mm2 = 0;  // squared, along the floor
    float area_m2 = 0;
  };
  static int count_high(const Grid& grid, const Plane& plane, std::span<const std::uint8_t> open);
  bool find(const Grid& grid, Vec3f up, std::span<const std::uint8_t> open, Plane& plane);
  static void close(const Grid& grid, const Plane& plane, std::span<std::uint8_t> open);
  void collect_voters(const Grid& grid, std::span<const std::uint8_t> open);
  bool search(const Grid& grid, Vec3f up, std::span<const std::uint8_t> open, Plane& best);
  void collect_on(const Grid& grid, std::span<const std::uint8_t> open, const Plane& plane, int row);
  bool refine(const Grid& grid, std::span<const std::uint8_t> open, Plane& plane, Extent& extent);

  std::vector<float> ray_x_, ray_y_, z_mm_, near_mm_, far_mm_;  // of the open cells that vote
  int voter_count_ = 0;
  std::vector<std::uint8_t> on_;  // of a row: on the wall
  struct RowCells {
    std::vector<float> ray_x, z_mm, inverse_z;
    std::size_t count = 0;
  } row_on_;  // those, the first `count` of each
  std::optional<Followed> followed_;
};

}  // namespace im2fit::segment
