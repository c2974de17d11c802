// SPDX-License-Identifier: Apache-2.0
#include <cassert>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "kernels/unproject/unproject.h"

namespace im2fit {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

RaySlope slope(int pixel, float centre, float focal) {
  constexpr double kLimit = 3.999;
  const double s = (double{static_cast<float>(pixel)} - double{centre}) / double{focal};
  return RaySlope::from_real(s > kLimit ? kLimit : s > -kLimit ? s : -kLimit);
}

}  // namespace

RayTable::RayTable(int width_max, int height_max)
    : columns_(static_cast<std::size_t>(width_max)), rows_(static_cast<std::size_t>(height_max)) {}

void RayTable::set(const Intrinsics& intrinsics) {
  assert(static_cast<std::size_t>(intrinsics.width) <= columns_.size());
  assert(static_cast<std::size_t>(intrinsics.height) <= rows_.size());
  intrinsics_ = intrinsics;
  for (int u = 0; u < intrinsics.width; ++u) {
    columns_[static_cast<std::size_t>(u)] = slope(u, intrinsics.cx, intrinsics.fx);
  }
  for (int v = 0; v < intrinsics.height; ++v) {
    rows_[static_cast<std::size_t>(v)] = slope(v, intrinsics.cy, intrinsics.fy);
  }
}

static_assert(sizeof(RaySlope) == sizeof(std::int32_t) && std::is_standard_layout_v<RaySlope>);

const std::int32_t* RayTable::column_raws() const {
  return reinterpret_cast<const std::int32_t*>(columns_.data());
}
const std::int32_t* RayTable::row_raws() const {
  return reinterpret_cast<const std::int32_t*>(rows_.data());
}

void unproject_portable(DepthView depth, int fraction_bits, const RayTable& rays, float* x, float* y, float* z) {
  constexpr float kUnit = 1.0F / (1 << CoordinateMm::kFractionBits);
  std::size_t i = 0;
  for (int v = 0; v < depth.height; ++v) {
    const std::uint16_t* row = depth.row(v);
    for (int u = 0; u < depth.width; ++u, ++i) {
      if (row[u] == 0) {
        x[i] = y[i] = z[i] = kNan;
        continue;
      }
      const FixedPoint3 p = rays.point(u, v, row[u], fraction_bits);
      x[i] = static_cast<float>(p.x.raw()) * kUnit;
      y[i] = static_cast<float>(p.y.raw()) * kUnit;
      z[i] = static_cast<float>(p.z.raw()) * kUnit;
    }
  }
}

}  // namespace im2fit
