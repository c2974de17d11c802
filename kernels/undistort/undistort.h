// SPDX-License-Identifier: Apache-2.0
// A depth picture without its lens: each pixel of the pinhole's picture is the camera's pixel nearest to where its
// ray lands. Depths must not be interpolated, between two surfaces there is none; so the ray of a pixel is right to
// half a pixel, 2.2 mm sideways at 2.5 m and 575 pixels of focal length. The table goes from the pinhole to the
// camera, which is the way the lens' formula goes: nothing is inverted, nothing iterated.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/tier.h"

namespace im2fit {

// `count` pixels from `to` on come from `from` on; from < 0: no data. Lenses bend little: copying runs
// takes 0.4 of the time of looking up pixels, with a lens of 12 % at the picture's edge.
struct UndistortRun {
  std::int32_t to, from, count;
};

// `table`: for each pixel of the undistorted picture the index of the camera's, -1 for none.
std::vector<UndistortRun> undistort_runs(std::span<const std::int32_t> table);

// `in` and `out` hold `pixels` values and do not overlap; the runs cover all of `out` in order and stay inside `in`.
// No allocation, thread-safe. All tiers agree bit for bit.
using UndistortFunction = void(const std::uint16_t* in, int pixels, const UndistortRun* runs, int run_count,
                               std::uint16_t* out);
UndistortFunction undistort_portable;
UndistortFunction undistort;  // the fastest here

using UndistortKernel = KernelVariant<UndistortFunction>;
inline constexpr UndistortKernel kUndistortKernels[] = {IM2FIT_PORTABLE(undistort)};

}  // namespace im2fit
