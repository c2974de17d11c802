// SPDX-License-Identifier: Apache-2.0
#include "kernels/rayform/ray_form.h"

#include <cassert>
#include <cstddef>

namespace im2fit {

RayForm::RayForm(int width_max, int height_max)
    : columns_(static_cast<std::size_t>(width_max)), rows_(static_cast<std::size_t>(height_max)) {}

void RayForm::set(const RayTable& rays, Vec3f axis) {
  using Axis = Fixed<std::int32_t, 30>;
  const auto width = static_cast<std::size_t>(rays.intrinsics().width);
  const auto height = static_cast<std::size_t>(rays.intrinsics().height);
  assert(width <= columns_.size() && height <= rows_.size());
  const Axis x = Axis::from_real(axis.x), y = Axis::from_real(axis.y);
  const FormSlope z = rescale<FormSlope::kFractionBits>(Axis::from_real(axis.z));
  for (std::size_t u = 0; u < width; ++u) columns_[u] = (x * rays.column(static_cast<int>(u))).raw();
  for (std::size_t v = 0; v < height; ++v) rows_[v] = (y * rays.row(static_cast<int>(v)) + z).raw();
}

void set_camera(RayTable& rays, const Intrinsics& k) {
  const Intrinsics& had = rays.intrinsics();
  const bool same = had.width == k.width && had.height == k.height && had.fx == k.fx && had.fy == k.fy &&
                    had.cx == k.cx && had.cy == k.cy;
  if (!same) rays.set(k);
}

std::int32_t form_offset(double mm) {
  constexpr double kLimitMm = static_cast<double>(kFormOffsetMax >> CoordinateMm::kFractionBits);
  if (mm != mm) return 0;
  return CoordinateMm::from_real(mm > kLimitMm ? kLimitMm : mm < -kLimitMm ? -kLimitMm : mm).raw();
}

}  // namespace im2fit
