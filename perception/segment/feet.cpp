// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/feet.h"

#include <algorithm>
#include <cmath>
#include <cstring>

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [bits]  from rounding or the width of a word: changes the time, not the mask
//   [rooms] chosen on synthetic rooms, no measurement on record
namespace im2fit::segment::feet_limits {

constexpr float kFootTopMm = 160.0F;      // above the floor: feet are grown from mask pixels below; [rooms]
constexpr float kFootClearMm = 18.0F;     // above the floor, least: its noise; [rooms]
constexpr float kFootClearQuanta = 0.6F;  // and so many disparity steps, as height; [rooms]
constexpr int kFootReachPx = 48;          // at 640 px: sideways and downwards from the mask; [rooms]
constexpr float kFootStepMm = 30.0F;      // depth from pixel to pixel, with a disparity step, most; [rooms]
constexpr float kMaskReachMm = 500.0F;    // of a mask pixel behind a cell of the person beside it, most; [bits]
constexpr float kSlackMm = 1.0F;          // far above what rounding does to a height; [bits]
constexpr float kToeTopMm = 70.0F;        // above the floor: below, a shoe's front is followed down; [rooms]
constexpr float kToeNearMm = 15.0F;       // before the front, with half a disparity step: it is the floor; [rooms]

}  // namespace im2fit::segment::feet_limits

namespace im2fit::segment {

using namespace feet_limits;

namespace {

struct Box {
  int u_first, u_last, v_first, v_last;  // inclusive
};

// The chosen cells of a row: columns, inclusive, and depths.
struct Cells {
  int c_min, c_max;
  std::uint16_t nearest, farthest;
};

struct Grower {
  const Grid& grid;
  DepthView depth;
  FloorPlane floor;
  std::span<const std::uint8_t> barred;
  MaskImage mask;

  float height_of(int u, int v, float z) const {
    const Intrinsics& k = grid.intrinsics;
    return dot(floor.up, unproject(k, static_cast<float>(u), static_cast<float>(v), z)) + floor.camera_height_mm;
  }
  float clear_mm(float z) const {
    return kFootClearMm + kFootClearQuanta * quantum_mm(z) * floor.camera_height_mm / z;
  }
  bool is_barred(int u, int v) const {
    const int c = std::min(u / grid.step, grid.width - 1), r = std::min(v / grid.step, grid.height - 1);
    return barred[at(grid.index(c, r))] != 0;
  }
  bool take(int u, int v, int from_u, int from_v) const {
    if (mask.at(u, v) != 0 || mask.at(from_u, from_v) == 0) return false;
    const std::uint16_t raw = depth.at(u, v);
    if (raw == 0 || raw > kDepthMaxMm) return false;
    const float z = static_cast<float>(raw);
    const float from = static_cast<float>(depth.at(from_u, from_v));
    if (std::fabs(z - from) > kFootStepMm + quantum_mm(z)) return false;
    const float height = height_of(u, v, z);
    if (height > kFootTopMm || height < clear_mm(z) || is_barred(u, v)) return false;
    mask.at(u, v) = 255;
    return true;
  }

  // Whether row v may hold a foot: the least height over its columns and the depths of the cells it lies in.
  bool may_be_low(int v, float z_min, float z_max) const {
    const Intrinsics& k = grid.intrinsics;
    const float row = floor.up.y * (static_cast<float>(v) - k.cy) / k.fy + floor.up.z;
    const float left = row - floor.up.x * k.cx / k.fx;
    const float right = row + floor.up.x * (static_cast<float>(mask.width - 1) - k.cx) / k.fx;
    const float slope = std::min(left, right);
    const float z = slope < 0 ? z_max : z_min;  // heights are linear in both: the least is at a corner
    return slope * z + floor.camera_height_mm <= kFootTopMm + kSlackMm;
  }

  bool is_low(int u, int v) const {
    return mask.at(u, v) != 0 && !(height_of(u, v, static_cast<float>(depth.at(u, v))) > kFootTopMm);
  }
  // The mask's pixels at foot height; v_last < 0 where there are none.
  Cells cells_of(std::span<const std::uint8_t> chosen, int row) const;
  Box low_box(std::span<const std::uint8_t> chosen) const;
  void sweep_right(int v, const Box& box) const;
  void sweep_left(int v, const Box& box) const;
  void close_to_floor(const Box& box, std::span<std::int16_t> lowest) const;
};

Box Grower::low_box(std::span<const std::uint8_t> chosen) const {
  Box box = {mask.width, -1, mask.height, -1};
  Cells above = cells_of(chosen, -1), here = above, below = cells_of(chosen, 0);
  for (int r = 0; r < grid.height; ++r) {
    above = here;
    here = below;
    below = cells_of(chosen, r + 1);
    const int c_min = std::min({above.c_min, here.c_min, below.c_min});
    const int c_max = std::max({above.c_max, here.c_max, below.c_max});
    if (c_max < 0) continue;
    const std::uint16_t nearest = std::min({above.nearest, here.nearest, below.nearest});
    const std::uint16_t farthest = std::max({above.farthest, here.farthest, below.farthest});
    const float z_min = std::max(0.0F, static_cast<float>(nearest) - kMaskReachMm);
    const float z_max = static_cast<float>(farthest) + kMaskReachMm;
    const int v_end = r + 1 == grid.height ? mask.height : (r + 1) * grid.step;
    const int u_begin = std::max(0, c_min - 1) * grid.step;
    const int u_end = c_max + 2 >= grid.width ? mask.width : (c_max + 2) * grid.step;
    for (int v = r * grid.step; v < v_end; ++v) {
      if (!may_be_low(v, z_min, z_max)) continue;
      int u_first = u_begin, u_last = u_end - 1;
      while (u_first <= u_last && !is_low(u_first, v)) ++u_first;
      if (u_first > u_last) continue;
      while (!is_low(u_last, v)) --u_last;
      box.v_first = std::min(box.v_first, v);
      box.v_last = std::max(box.v_last, v);
      box.u_first = std::min(box.u_first, u_first);
      box.u_last = std::max(box.u_last, u_last);
    }
  }
  return box;
}

constexpr int kWord = 8;  // pixels tested together

std::uint64_t word(const std::uint8_t* p) {
  std::uint64_t w = 0;
  std::memcpy(&w, p, sizeof w);
  return w;
}

Cells Grower::cells_of(std::span<const std::uint8_t> chosen, int row) const {
  Cells cells = {grid.width, -1, 65535, 0};
  if (row < 0 || row >= grid.height) return cells;
  for (int c = 0; c < grid.width; ++c) {
    const auto i = at(grid.index(c, row));
    if (chosen[i] == 0) continue;
    cells.nearest = std::min(cells.nearest, grid.depth[i]);
    cells.farthest = std::max(cells.farthest, grid.depth[i]);
    cells.c_min = std::min(cells.c_min, c);
    cells.c_max = c;
  }
  return cells;
}

// Nothing grows in a word that is full, nor in one that is empty and has only empty pixels before and above it.
void Grower::sweep_right(int v, const Box& box) const {
  const std::uint8_t* here = mask.row(v);
  const std::uint8_t* above = mask.row(v - 1);
  for (int u = box.u_first; u <= box.u_last; ++u) {
    while (u + kWord - 1 <= box.u_last) {
      const std::uint64_t own = word(here + u);
      const bool empty = (own | word(above + u)) == 0 && here[u - 1] == 0 && above[u - 1] == 0;
      if (!empty && own != ~std::uint64_t{0}) break;
      u += kWord;
    }
    if (u > box.u_last) break;
    if (!take(u, v, u, v - 1) && !take(u, v, u - 1, v)) take(u, v, u - 1, v - 1);
  }
}

void Grower::sweep_left(int v, const Box& box) const {
  const std::uint8_t* here = mask.row(v);
  const std::uint8_t* above = mask.row(v - 1);
  for (int u = box.u_last; u >= box.u_first; --u) {
    while (u - kWord + 1 >= box.u_first) {
      const std::uint64_t own = word(here + u - kWord + 1);
      const bool empty = (own | word(above + u - kWord + 1)) == 0 && here[u + 1] == 0 && above[u + 1] == 0;
      if (!empty && own != ~std::uint64_t{0}) break;
      u -= kWord;
    }
    if (u < box.u_first) break;
    if (!take(u, v, u + 1, v)) take(u, v, u + 1, v - 1);
  }
}

// The last millimetres: straight down the front of the shoe, until the surface turns towards the camera (floor).
void Grower::close_to_floor(const Box& box, std::span<std::int16_t> lowest) const {
  std::fill(lowest.begin(), lowest.end(), std::int16_t{-1});
  for (int v = box.v_first; v <= box.v_last; ++v) {
    const std::uint8_t* m = mask.row(v);
    const auto here = static_cast<std::int16_t>(v);
    for (int u = box.u_first; u <= box.u_last; ++u) {
      const auto i = at(u);
      lowest[i] = m[u] != 0 ? here : lowest[i];
    }
  }
  for (int u = box.u_first; u <= box.u_last; ++u) {
    const int v = lowest[at(u)];
    if (v < 0) continue;
    const float front = static_cast<float>(depth.at(u, v));
    if (height_of(u, v, front) > kToeTopMm) continue;
    for (int down = v + 1; down <= box.v_last; ++down) {
      const std::uint16_t raw = depth.at(u, down);
      if (raw == 0 || raw > kDepthMaxMm) break;
      const float z = static_cast<float>(raw);
      if (height_of(u, down, z) < 0.0F || z < front - kToeNearMm - 0.5F * quantum_mm(z) ||
          z > front + kFootStepMm + quantum_mm(z) || is_barred(u, down))
        break;
      mask.at(u, down) = 255;
    }
  }
}

}  // namespace

void FootGrower::run(const Grid& grid, DepthView depth, const FloorPlane& floor, std::span<const std::uint8_t> chosen,
                     std::span<const std::uint8_t> barred, MaskImage mask) {
  if (!floor.known) return;
  const Grower grower = {grid, depth, floor, barred, mask};
  Box box = grower.low_box(chosen);
  if (box.v_last < 0) return;
  const int reach = std::max(4, kFootReachPx * grid.step / 4);
  box.v_last = std::min(mask.height - 1, box.v_last + reach);
  box.u_first = std::max(1, box.u_first - reach);
  box.u_last = std::min(mask.width - 2, box.u_last + reach);
  for (int v = std::max(1, box.v_first); v <= box.v_last; ++v) {
    grower.sweep_right(v, box);
    grower.sweep_left(v, box);
  }
  grower.close_to_floor(box, lowest_);
}

}  // namespace im2fit::segment
