// SPDX-License-Identifier: Apache-2.0
#include "perception/joints/snap_to_mask.h"

#include <algorithm>

#include "perception/joints/model_data.h"

namespace im2fit::joints {
namespace {

constexpr float kBeforeMm = 100.0F;  // least, from a joint to the surface behind it, to see through the joint

bool seen_through(Vec3f p, DepthView depth, const Intrinsics& k) {
  const float inverse_z = 1.0F / safe_depth(p.z);
  const int u = static_cast<int>(k.fx * p.x * inverse_z + k.cx + 0.5F);
  const int v = static_cast<int>(k.fy * p.y * inverse_z + k.cy + 0.5F);
  if (u < 0 || v < 0 || u >= depth.width || v >= depth.height) return false;
  const int z = depth.row(v)[u];
  return z == 0 || static_cast<float>(z) > p.z + kBeforeMm;
}

}  // namespace

Vec3f snap_to_mask(Vec3f p, const View& view, DepthView depth, const Intrinsics& k) {
  const float z = safe_depth(p.z);
  const float rx = p.x / z;
  const float ry = p.y / z;
  if (view.at_ray(rx, ry) != 0 || !seen_through(p, depth, k)) return p;
  const int u = view.column_of(rx);
  const int v = view.row_of(ry);
  const int reach = static_cast<int>(kSnapReachMm * view.fx / z);
  int nearest = reach * reach + 1;
  int to_u = u;
  int to_v = v;
  for (int row = std::max(0, v - reach); row <= std::min(view.height - 1, v + reach); ++row)
    for (int col = std::max(0, u - reach); col <= std::min(view.width - 1, u + reach); ++col) {
      const int away = (row - v) * (row - v) + (col - u) * (col - u);
      if (away >= nearest) continue;
      const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(view.width);
      if (view.depth[at + static_cast<std::size_t>(col)] == 0) continue;
      nearest = away;
      to_u = col;
      to_v = row;
    }
  return {p.x + static_cast<float>(to_u - u) * z / view.fx, p.y + static_cast<float>(to_v - v) * z / view.fy, p.z};
}

}  // namespace im2fit::joints
