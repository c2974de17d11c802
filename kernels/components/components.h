// SPDX-License-Identifier: Apache-2.0
// Connected surfaces of a depth picture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace im2fit {

// Allocates only when made; not shareable between threads.
class Components {
 public:
  Components(int width, int height);

  // Labels 1, 2, ... in reading order of each surface's first cell, 0 for closed cells, surfaces of fewer than
  // `cells_min` cells and those after the `count_max`th. Open neighbours (eight directions, or straight over one cell
  // without data) are one surface when their depths differ by less than 40 mm + 1.5 disparity steps of the nearer
  // one. Returns the number of labels. All spans have width * height values; depths of open cells are 1..10000 mm.
  int run(std::span<const std::uint16_t> depth, std::span<const std::uint8_t> open, int cells_min, int count_max,
          std::span<std::uint16_t> labels);

 private:
  struct Run {
    std::int32_t first = 0, count = 0;  // cells
  };
  void find_surfaces(std::span<const std::uint16_t> depth, std::span<const std::uint8_t> open);
  void list_runs();
  void join();
  void join_down(std::int32_t here, bool in_run);
  void unite(std::int32_t a, std::int32_t b);  // cells
  std::int32_t root(std::int32_t start);

  int width_, height_;
  std::vector<std::uint16_t> surface_, limit_;
  std::vector<std::uint8_t> links_;
  std::vector<std::int32_t> start_;          // of each open cell: the first of its run
  std::vector<std::int32_t> parent_, size_;  // of the first cell of each run
  std::vector<std::uint16_t> label_;         // of the first cell of each surface
  std::vector<Run> runs_;                    // in reading order, the first run_count_
  std::int32_t run_count_ = 0;
};

}  // namespace im2fit
