// SPDX-License-Identifier: Apache-2.0
#include "kernels/joints/view.h"

#include <algorithm>

namespace im2fit::joints {
namespace {

// The first masked pixel of a step x step block: thinning by choice, not by mean, makes no depth between two limbs.
std::uint16_t first_masked(DepthView depth, MaskView mask, int u0, int v0, int step) {
  for (int v = v0; v < std::min(v0 + step, depth.height); ++v)
    for (int u = u0; u < std::min(u0 + step, depth.width); ++u)
      if (mask.at(u, v) != 0 && depth.at(u, v) != 0) return depth.at(u, v);
  return 0;
}

}  // namespace

bool thin(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, View& view) {
  view.width = view.height = view.pixel_count = 0;
  const int u_min = std::max(0, person.u_min);
  const int v_min = std::max(0, person.v_min);
  const int u_max = std::min(depth.width - 1, person.u_max);
  const int v_max = std::min(depth.height - 1, person.v_max);
  if (u_min > u_max || v_min > v_max) return false;
  int step = std::max(1, static_cast<int>(k.fx / kViewFocalPx + 0.5F));
  const auto side = [&](int low, int high) { return static_cast<std::size_t>(high / step - low / step + 1); };
  while (side(u_min, u_max) * side(v_min, v_max) > kViewPixelCountMax) ++step;

  const float scale = 1.0F / static_cast<float>(step);
  const float shift = 0.5F * static_cast<float>(step - 1);
  view.fx = k.fx * scale;
  view.fy = k.fy * scale;
  view.cx = (k.cx - shift) * scale;
  view.cy = (k.cy - shift) * scale;
  view.u_first = u_min / step;
  view.v_first = v_min / step;
  view.width = u_max / step - view.u_first + 1;
  view.height = v_max / step - view.v_first + 1;
  const std::size_t count = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  if (view.depth.size() < count) view.depth.resize(count);
  std::uint64_t sum_z = 0;
  double sum_uz = 0;
  double sum_vz = 0;
  for (int v = 0; v < view.height; ++v) {
    std::uint64_t row_z = 0;
    std::uint64_t row_uz = 0;
    std::uint16_t* out = view.depth.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(view.width);
    for (int u = 0; u < view.width; ++u) {
      const std::uint16_t z = first_masked(depth, mask, (u + view.u_first) * step, (v + view.v_first) * step, step);
      out[u] = z;
      if (z == 0) continue;
      ++view.pixel_count;
      row_z += z;
      row_uz += static_cast<std::uint64_t>(z) * static_cast<std::uint64_t>(u);
    }
    sum_z += row_z;
    sum_uz += static_cast<double>(row_uz);
    sum_vz += static_cast<double>(row_z) * v;
  }
  if (view.pixel_count == 0) return false;
  const double n = view.pixel_count;
  const double z = static_cast<double>(sum_z);
  const double left = static_cast<double>(view.cx) - view.u_first;
  const double top = static_cast<double>(view.cy) - view.v_first;
  view.centroid_mm = {static_cast<float>((sum_uz - left * z) / (n * static_cast<double>(view.fx))),
                      static_cast<float>((sum_vz - top * z) / (n * static_cast<double>(view.fy))),
                      static_cast<float>(z / n)};
  return true;
}

}  // namespace im2fit::joints
