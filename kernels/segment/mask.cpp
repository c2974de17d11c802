// SPDX-License-Identifier: Apache-2.0
#include "kernels/segment/mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace im2fit::segment {
namespace {

constexpr float kFootTopMm = 160.0F;   // feet are grown from mask pixels below this height
constexpr float kFootClearMm = 18.0F;  // above the floor's noise
constexpr int kFootReachPx = 48;       // at 640 px: sideways and downwards from the mask

struct Neighbours {
  std::array<float, 9> person{};
  std::array<float, 9> other{};
  int person_count = 0;
  int other_count = 0;
};

Neighbours neighbours_of(const Grid& grid, std::span<const std::uint8_t> chosen, int c, int r) {
  Neighbours out;
  for (int dr = -1; dr <= 1; ++dr) {
    for (int dc = -1; dc <= 1; ++dc) {
      const int cc = c + dc;
      const int rr = r + dr;
      if (cc < 0 || rr < 0 || cc >= grid.width || rr >= grid.height) continue;
      const auto i = static_cast<std::size_t>(grid.index(cc, rr));
      if (grid.depth[i] == 0) continue;
      const float z = static_cast<float>(grid.depth[i]);
      if (chosen[i] != 0) {
        out.person[static_cast<std::size_t>(out.person_count++)] = z;
      } else {
        out.other[static_cast<std::size_t>(out.other_count++)] = z;
      }
    }
  }
  return out;
}

bool belongs(const Neighbours& around, float z) {
  float best = 1e9F;
  for (int i = 0; i < around.person_count; ++i)
    best = std::min(best, std::fabs(z - around.person[static_cast<std::size_t>(i)]));
  if (best > depth_step_mm(z)) return false;
  for (int i = 0; i < around.other_count; ++i)
    if (std::fabs(z - around.other[static_cast<std::size_t>(i)]) < best) return false;
  return true;
}

struct FootGrower {
  const Grid& grid;
  DepthView depth;
  FloorPlane floor;
  MaskImage mask;

  float height_of(int u, int v, float z) const {
    const Intrinsics& k = grid.intrinsics;
    return dot(floor.up, unproject(k, static_cast<float>(u), static_cast<float>(v), z)) + floor.camera_height_mm;
  }
  float clear_mm(float z) const { return kFootClearMm + 0.6F * quantum_mm(z) * floor.camera_height_mm / z; }
  bool take(int u, int v, int from_u, int from_v) {
    if (mask.at(u, v) != 0 || mask.at(from_u, from_v) == 0) return false;
    const std::uint16_t raw = depth.at(u, v);
    if (raw == 0 || raw > kDepthMaxMm) return false;
    const float z = static_cast<float>(raw);
    const float from = static_cast<float>(depth.at(from_u, from_v));
    const float height = height_of(u, v, z);
    if (height > kFootTopMm || height < clear_mm(z)) return false;
    if (std::fabs(z - from) > 30.0F + quantum_mm(z)) return false;
    mask.at(u, v) = 255;
    return true;
  }
};

}  // namespace

void refine_mask(const Grid& grid, DepthView depth, std::span<const std::uint8_t> chosen, MaskImage mask) {
  for (int v = 0; v < mask.height; ++v) std::memset(mask.row(v), 0, static_cast<std::size_t>(mask.width));
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const auto i = static_cast<std::size_t>(grid.index(c, r));
      const bool near_person = chosen[i] != 0 || (c > 0 && chosen[i - 1] != 0) ||
                               (c + 1 < grid.width && chosen[i + 1] != 0) ||
                               (r > 0 && chosen[i - static_cast<std::size_t>(grid.width)] != 0) ||
                               (r + 1 < grid.height && chosen[i + static_cast<std::size_t>(grid.width)] != 0);
      if (!near_person) continue;
      const Neighbours around = neighbours_of(grid, chosen, c, r);
      const float own = chosen[i] != 0 ? static_cast<float>(grid.depth[i]) : 0.0F;
      const bool interior = around.other_count == 0 && own > 0;
      const int v_end = r + 1 == grid.height ? mask.height : (r + 1) * grid.step;
      const int u_end = c + 1 == grid.width ? mask.width : (c + 1) * grid.step;
      for (int v = r * grid.step; v < v_end; ++v) {
        const std::uint16_t* z_row = depth.row(v);
        std::uint8_t* out = mask.row(v);
        for (int u = c * grid.step; u < u_end; ++u) {
          if (z_row[u] == 0 || z_row[u] > kDepthMaxMm) continue;
          const float z = static_cast<float>(z_row[u]);
          if ((interior && std::fabs(z - own) < 40.0F) || belongs(around, z)) out[u] = 255;
        }
      }
    }
  }
}

void grow_feet(const Grid& grid, DepthView depth, const FloorPlane& floor, MaskImage mask) {
  if (!floor.known) return;
  FootGrower grow{grid, depth, floor, mask};
  int v_first = mask.height;
  int v_last = -1;
  int u_first = mask.width;
  int u_last = -1;
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      if (mask.at(u, v) == 0 || grow.height_of(u, v, static_cast<float>(depth.at(u, v))) > kFootTopMm) continue;
      v_first = std::min(v_first, v);
      v_last = std::max(v_last, v);
      u_first = std::min(u_first, u);
      u_last = std::max(u_last, u);
    }
  }
  if (v_last < 0) return;
  const int reach = std::max(4, kFootReachPx * grid.step / 4);
  v_last = std::min(mask.height - 1, v_last + reach);
  u_first = std::max(1, u_first - reach);
  u_last = std::min(mask.width - 2, u_last + reach);
  for (int v = std::max(1, v_first); v <= v_last; ++v) {
    for (int u = u_first; u <= u_last; ++u)
      if (!grow.take(u, v, u, v - 1) && !grow.take(u, v, u - 1, v)) grow.take(u, v, u - 1, v - 1);
    for (int u = u_last; u >= u_first; --u)
      if (!grow.take(u, v, u + 1, v)) grow.take(u, v, u + 1, v - 1);
  }
  // The last millimetres: straight down the front of the shoe, until the surface turns towards the camera (floor).
  for (int u = u_first; u <= u_last; ++u) {
    int v = v_last;
    while (v >= v_first && mask.at(u, v) == 0) --v;
    if (v < v_first) continue;
    const float front = static_cast<float>(depth.at(u, v));
    if (grow.height_of(u, v, front) > 70.0F) continue;
    for (int down = v + 1; down <= v_last; ++down) {
      const std::uint16_t raw = depth.at(u, down);
      if (raw == 0 || raw > kDepthMaxMm) break;
      const float z = static_cast<float>(raw);
      if (grow.height_of(u, down, z) < 0.0F || z < front - 15.0F - 0.5F * quantum_mm(z) ||
          z > front + 30.0F + quantum_mm(z))
        break;
      mask.at(u, down) = 255;
    }
  }
}

void describe_mask(const Grid& grid, DepthView depth, MaskView mask, Person& person) {
  const Intrinsics& k = grid.intrinsics;
  person.u_min = mask.width;
  person.v_min = mask.height;
  person.u_max = person.v_max = -1;
  double sum_z = 0;
  double sum_uz = 0;
  double sum_vz = 0;
  int count = 0;
  for (int v = 0; v < mask.height; ++v) {
    const std::uint8_t* m = mask.row(v);
    const std::uint16_t* z_row = depth.row(v);
    std::uint64_t row_z = 0;
    std::uint64_t row_uz = 0;
    int row_count = 0;
    for (int u = 0; u < mask.width; ++u) {
      if (m[u] == 0) continue;
      ++row_count;
      row_z += z_row[u];
      row_uz += static_cast<std::uint64_t>(u) * z_row[u];
      person.u_min = std::min(person.u_min, u);
      person.u_max = std::max(person.u_max, u);
    }
    if (row_count == 0) continue;
    person.v_min = std::min(person.v_min, v);
    person.v_max = v;
    count += row_count;
    sum_z += static_cast<double>(row_z);
    sum_uz += static_cast<double>(row_uz);
    sum_vz += static_cast<double>(row_z) * v;
  }
  person.pixel_count = count;
  if (count == 0) return;
  const double n = count;
  person.centroid_mm = {
      static_cast<float>((sum_uz - static_cast<double>(k.cx) * sum_z) / (n * static_cast<double>(k.fx))),
      static_cast<float>((sum_vz - static_cast<double>(k.cy) * sum_z) / (n * static_cast<double>(k.fy))),
      static_cast<float>(sum_z / n)};
  person.cut_top = person.v_min <= 1;
  person.cut_bottom = person.v_max >= mask.height - 2;
  person.cut_left = person.u_min <= 1;
  person.cut_right = person.u_max >= mask.width - 2;
}

}  // namespace im2fit::segment
