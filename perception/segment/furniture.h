// SPDX-License-Identifier: Apache-2.0
// Boxes, stools and the like that stand at a person's legs and are one surface with them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/segment/grid.h"

namespace im2fit::segment {

class FurnitureCutter {
 public:
  explicit FurnitureCutter(const Grid& grid);
  // Removes from `chosen` (1 to 0) surfaces that begin at a level edge low above the floor, without the person above
  // them, and go down flat; of a seated person also surfaces behind the shins and between or flat beside them. Does
  // nothing without a floor.
  void run(const Grid& grid, const FloorPlane& floor, std::span<std::uint8_t> chosen);
  // 1 per cell taken away by the last run.
  std::span<const std::uint8_t> cut() const { return cut_; }

 private:
  // Columns of cells, inclusive.
  struct Ledge {
    int c_first = 0, c_last = -1;
  };

  void find_tops(const Grid& grid, float limit_mm, std::span<const std::uint8_t> chosen);
  Ledge next_ledge(const Grid& grid, int c) const;
  void follow_down(const Grid& grid, Vec3f ahead, const Ledge& ledge, std::span<const std::uint8_t> chosen);
  bool flat(const Grid& grid, const Ledge& ledge) const;
  bool cut_ledges(const Grid& grid, Vec3f ahead, float limit_mm, std::span<std::uint8_t> chosen);
  void find_posts(const Grid& grid, int row, float limit_mm, std::span<const std::uint8_t> chosen);
  void cut_posts(const Grid& grid, float limit_mm, std::span<const std::uint8_t> chosen);
  void cut_seat(const Grid& grid, Vec3f ahead, float limit_mm, std::span<std::uint8_t> chosen);
  float distance_between(const Grid& grid, Vec3f ahead, float low_mm, float high_mm,
                         std::span<const std::uint8_t> chosen);
  float shins_before_trunk_mm(const Grid& grid, Vec3f ahead, float tall_mm, std::span<const std::uint8_t> chosen);
  void cut_behind(const Grid& grid, Vec3f ahead, float tall_mm, std::span<std::uint8_t> chosen);
  void cut_row(const Grid& grid, int row, float limit_mm, std::span<std::uint8_t> chosen);
  void cut_below_and_above(const Grid& grid, Vec3f ahead, int c, int r, std::span<std::uint8_t> chosen);
  void take(const Grid& grid, Vec3f ahead, const Ledge& ledge, std::span<std::uint8_t> chosen);
  void take_beside(const Grid& grid, Vec3f ahead, const Ledge& ledge, std::span<std::uint8_t> chosen);
  void drop_loose(const Grid& grid, float limit_mm, bool seated, std::span<std::uint8_t> chosen);

  std::vector<std::uint8_t> cut_;
  std::vector<std::int32_t> top_, bottom_;  // rows, per column; -1: none
  std::vector<float> front_mm_;             // distance along the floor
  std::vector<std::int32_t> island_;        // per cell, 0: not visited
  std::vector<std::int32_t> stack_;
  std::vector<std::int32_t> distances_;  // cells by distance along the floor
};

}  // namespace im2fit::segment
