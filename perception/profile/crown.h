// SPDX-License-Identifier: Apache-2.0
// Where the person ends above and below: heights at which the outline encloses given areas. A single topmost pixel
// is noise; some hundred square millimetres are a crown.
#pragma once

#include <cstdint>
#include <span>

#include "core/camera.h"
#include "kernels/rayform/ray_form.h"
#include "perception/profile/profile.h"
#include "perception/profile/row_scan.h"

namespace im2fit::profile {

inline constexpr int kHeightBins = 700;  // of kHeightBinMm each, from kHeightMinMm on
inline constexpr int kHeightBinMm = 4;   // a power of two, so that a bin is a shift
inline constexpr int kHeightMinMm = -100;

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
// left out; 2^22 pixels of 2^32 stay below 2^54. Returns the lowest height of all points that count, within or
// outside the bins, as a CoordinateMm raw; kHeightNone where nothing counts. Integers. No allocation, thread-safe.
std::int32_t sum_by_height(const HeightScan& scan, std::uint64_t* squares);

// Heights above the floor. Where no floor is known, sets the frame so that the lowest point is the zero of heights.
// Reads the workspace's outline and its tables of heights and sides. Leaves crown and soles as they are where the
// head is nowhere.
void crown_and_soles(Scene& s, bool floor_known, ProfileWorkspace& work, std::span<float> crown,
                     std::span<float> soles);

}  // namespace im2fit::profile
