// SPDX-License-Identifier: Apache-2.0
// Lens distortion of a calibration, undone at the edge: everything behind the HAL is a pinhole camera.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/status.h"

namespace im2fit::hal {

// OpenCV's order: k1 k2 p1 p2 k3 k4 k5 k6 ("plumb_bob" has the first five, "rational_polynomial" all).
struct Distortion {
  std::array<double, 8> coefficients{};
  bool any() const;
};

// Where in the camera's picture a pinhole's ray (x, y, 1) is seen, in pixels; the centre of pixel 0 is 0.
struct PicturePoint {
  double u = 0, v = 0;
};
PicturePoint seen_at(const Intrinsics& k, const Distortion& distortion, double x, double y);
// The index of the pixel there, row by row; -1 outside the picture.
std::int32_t pixel_at(const Intrinsics& k, const PicturePoint& point);

// Error: invalid_argument when less than half of the undistorted picture's pixels are seen. `what` names the file.
Status check_seen(std::size_t seen_count, std::size_t pixel_count, const std::string& what);

// For each pixel of the undistorted picture, row by row, the index of the camera's pixel nearest to where the ray is
// seen; -1 outside the camera's picture. Depths must not be interpolated: between two surfaces there is none. So the
// ray of a pixel is exact to half a pixel, 2.2 mm sideways at 2.5 m and 575 pixels of focal length. The table maps
// from the pinhole to the camera, in the direction of the lens formula, so nothing is inverted. The undistorted
// picture has the same intrinsics. Error: invalid_argument when the values do not describe a lens (not finite, or
// less than half of the picture is seen). `what` names the file.
Result<std::vector<std::int32_t>> undistortion_table(const Intrinsics& k, const Distortion& distortion,
                                                     const std::string& what);

// `count` pixels from `to` on come from `from` on; from < 0: no data. Lenses bend little: copying runs takes 0.4 of
// the time of looking up pixels, with a lens of 12 % at the picture's edge.
struct UndistortRun {
  std::int32_t to, from, count;
};
// `table`: as undistortion_table gives it.
std::vector<UndistortRun> undistort_runs(std::span<const std::int32_t> table);
// `in` and `out` hold `pixels` values and do not overlap; the runs cover all of `out` in order and stay inside `in`.
// No allocation, thread-safe.
void undistort(const std::uint16_t* in, int pixels, std::span<const UndistortRun> runs, std::uint16_t* out);

}  // namespace im2fit::hal
