// SPDX-License-Identifier: Apache-2.0
// How much of what some rows show lies at which height: where a person ends above and below.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/rayform/ray_form.h"
#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kHeightBins = 700;  // of kHeightBinMm each, from kHeightMinMm on
inline constexpr int kHeightBinMm = 4;   // a power of two, so that a bin is a shift
inline constexpr int kHeightMinMm = -100;
inline constexpr int kHeightBinShift = CoordinateMm::kFractionBits + 2;

// The rows of `depth` and `mask`, and the tables of two axes for them: *_rows[0] belongs to the first row. Offsets
// are CoordinateMm raws within +-kFormOffsetMax; a point's height and side are its products plus these.
struct HeightScan {
  ImageView<const std::uint16_t> depth_q4;
  MaskView mask;
  const std::int32_t *up_columns, *up_rows;      // FormSlope raws
  const std::int32_t *side_columns, *side_rows;  // FormSlope raws
  std::int32_t up_offset, side_offset;
  std::int32_t side_max;  // only points with |side| < side_max count
};

inline constexpr std::int32_t kHeightNone = INT32_MAX;

// Sets kHeightBins sums of squared depths: in 1/256 mm^2 of a pixel's area times fx fy. Points outside the bins are
// left out; 2^22 pixels of 2^32 stay below 2^54. Returns the lowest height of all that count, in or outside the bins,
// as a CoordinateMm raw; kHeightNone where nothing counts. Integers. No allocation,
// thread-safe. `ref`: in double from the same tables; a point within 2^-10 mm of a bin's or the side's edge may fall
// to either side.
using HeightFunction = std::int32_t(const HeightScan& scan, std::uint64_t* squares);
HeightFunction height_portable, height;

inline constexpr KernelVariant<HeightFunction> kHeightKernels[] = {IM2FIT_PORTABLE(height)};

}  // namespace im2fit
