// SPDX-License-Identifier: Apache-2.0
// A coordinate of every point of a picture along one axis, for one multiplication a pixel.
//
// axis . p = z (axis . ray), and the ray of pixel (u, v) is (x/z of its column, y/z of its row, 1): the slope along
// the axis is a part of the column plus a part of the row, both in tables.
#pragma once

#include <cstdint>
#include <vector>

#include "core/fixed.h"
#include "core/vec3.h"
#include "kernels/unproject/unproject.h"

namespace im2fit {

// Slope along a unit axis: |x/z|, |y/z| < 4, so below sqrt(33) < 8. Each part is within 2^-28.4 of its real value.
using FormSlope = Fixed<std::int32_t, 28>;
// A depth of Q12.4 on its way into the product: raw < 2^25.
using FormDepth = Fixed<std::int32_t, 13>;
inline constexpr int kFormDepthShift = FormDepth::kFractionBits - 4;
// FormSlope * FormDepth is CoordinateMm: |.| < 5.75 * 4096 mm, raw < 2^25, rounded to 1/2048 mm. Depth times the
// slope's error is 2.4e-5 mm at most.
static_assert(decltype(FormSlope() * FormDepth())::kFractionBits == CoordinateMm::kFractionBits);
// Offsets added to such products stay within this (1048 m), so that sums and differences of two never overflow.
inline constexpr std::int32_t kFormOffsetMax = std::int32_t{1} << 30;

// The tables of one axis. Sized once; set() does not allocate up to that size.
class RayForm {
 public:
  RayForm() = default;
  RayForm(int width_max, int height_max);
  // `axis` unit (to 1e-6). The table's own size counts: `rays` was set for at most this form's size.
  void set(const RayTable& rays, Vec3f axis);
  const std::int32_t* columns() const { return columns_.data(); }  // raws of FormSlope
  const std::int32_t* rows() const { return rows_.data(); }        // raws of FormSlope

 private:
  std::vector<std::int32_t> columns_, rows_;
};

// Tables of one camera are made once: set() again only where the camera is another one.
void set_camera(RayTable& rays, const Intrinsics& intrinsics);

// The nearest CoordinateMm within +-kFormOffsetMax; NaN gives zero.
std::int32_t form_offset(double mm);

// A coordinate without its offset, as the SIMD tiers compute it lane by lane.
inline std::int32_t form_product(std::int32_t slope, std::uint16_t depth_q4) {
  return rounding_doubling_high_multiply(slope, std::int32_t{depth_q4} << kFormDepthShift);
}

}  // namespace im2fit
