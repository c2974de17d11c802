// SPDX-License-Identifier: Apache-2.0
#include "perception/joints/view.h"

#include <algorithm>

#include "kernels/downsample/downsample_box.h"

namespace im2fit::joints {

bool downsample(DepthView depth, MaskView mask, const Intrinsics& k, const Person& person, View& view) {
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
  DownsampleMoments moments;
  downsample_box({depth, mask, step, view.u_first, view.v_first, view.width, view.height}, view.depth.data(),
                 moments);
  view.pixel_count = static_cast<int>(moments.count);
  if (view.pixel_count == 0) return false;
  const double n = view.pixel_count;
  const double z = static_cast<double>(moments.z);
  const double uz = static_cast<double>(moments.uz);
  const double vz = static_cast<double>(moments.vz);
  const double left = static_cast<double>(view.cx) - view.u_first;
  const double top = static_cast<double>(view.cy) - view.v_first;
  view.centroid_mm = {static_cast<float>((uz - left * z) / (n * static_cast<double>(view.fx))),
                      static_cast<float>((vz - top * z) / (n * static_cast<double>(view.fy))),
                      static_cast<float>(z / n)};
  return true;
}

void mirror(const View& view, View& out) {
  out.u_first = view.u_first;
  out.v_first = view.v_first;
  out.width = view.width;
  out.height = view.height;
  out.fx = view.fx;
  out.fy = view.fy;
  out.cx = static_cast<float>(2 * view.u_first + view.width - 1) - view.cx;
  out.cy = view.cy;
  out.centroid_mm = {-view.centroid_mm.x, view.centroid_mm.y, view.centroid_mm.z};
  out.pixel_count = view.pixel_count;
  const std::size_t count = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  if (out.depth.size() < count) out.depth.resize(count);
  for (std::size_t first = 0; first < count; first += static_cast<std::size_t>(view.width)) {
    const std::uint16_t* from = view.depth.data() + first;
    std::reverse_copy(from, from + view.width, out.depth.data() + first);
  }
}

}  // namespace im2fit::joints
