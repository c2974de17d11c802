// SPDX-License-Identifier: Apache-2.0
#include "kernels/joints/view.h"

#include <algorithm>

#include "kernels/joints/thin/thin_box.h"

namespace im2fit::joints {

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
  ThinMoments moments;
  thin_box({depth, mask, step, view.u_first, view.v_first, view.width, view.height}, view.depth.data(), moments);
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

}  // namespace im2fit::joints
