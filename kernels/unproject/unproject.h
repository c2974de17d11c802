// SPDX-License-Identifier: Apache-2.0
// A depth image to an organised cloud: x = (u - cx) z / fx, y = (v - cy) z / fy.
#pragma once

#include <span>
#include <vector>

#include "core/camera.h"
#include "core/fixed.h"
#include "kernels/tier.h"

namespace im2fit {

// Slope of a pixel's ray, x/z or y/z: below 4 (a half field of view of 76 degrees; wider rays are clamped).
using RaySlope = Fixed<std::int32_t, 29>;
// A depth on its way into a product; up to 524 m.
using DepthMm = Fixed<std::int32_t, 12>;
// A coordinate: 1/1024 mm.
using CoordinateMm = Fixed<std::int32_t, 10>;

struct FixedPoint3 {
  CoordinateMm x, y, z;
};

// The slopes of all columns and rows of one camera. Sized once; set() does not allocate up to that size.
class RayTable {
 public:
  RayTable(int width_max, int height_max);
  void set(const Intrinsics& intrinsics);
  const Intrinsics& intrinsics() const { return intrinsics_; }
  RaySlope column(int u) const { return columns_[static_cast<std::size_t>(u)]; }
  RaySlope row(int v) const { return rows_[static_cast<std::size_t>(v)]; }
  // The raw values, for code that takes them many at a time.
  const std::int32_t* column_raws() const;
  const std::int32_t* row_raws() const;

  // `raw` is a depth of `fraction_bits` fraction bits: 0 for mm, 4 for 1/16 mm. Every value fits: 65535 mm x 4 <
  // 2^21.
  FixedPoint3 point(int u, int v, std::uint16_t raw, int fraction_bits) const {
    const DepthMm z = DepthMm::from_raw(std::int32_t{raw} << (DepthMm::kFractionBits - fraction_bits));
    return {column(u) * z, row(v) * z, CoordinateMm::from_raw(std::int32_t{raw} << (10 - fraction_bits))};
  }

 private:
  Intrinsics intrinsics_;
  std::vector<RaySlope> columns_, rows_;
};

// x, y, z: width*height values in mm, NaN in all three where depth is 0. `depth` has the table's size; fraction_bits
// 0..10 of its values (0: mm, 4: 1/16 mm). No allocation, thread-safe. Portable (fixed point) is within 1e-3 mm of
// ref up to 16 m: slope rounded to 2^-30 (1.5e-5 mm at 16 m), product to 2^-11 mm, float to 2^-10 mm between 8 and 16
// m. The frame path takes points one by one from RayTable; whole clouds are for tests and the golden run.
using UnprojectFunction = void(DepthView depth, int fraction_bits, const RayTable& rays, float* x, float* y,
                               float* z);
UnprojectFunction unproject_portable;

using UnprojectKernel = KernelVariant<UnprojectFunction>;
inline constexpr UnprojectKernel kUnprojectKernels[] = {IM2FIT_PORTABLE(unproject)};

}  // namespace im2fit
