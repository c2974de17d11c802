// SPDX-License-Identifier: Apache-2.0
#include "hal/undistort.h"

#include <cmath>

namespace im2fit::hal {
namespace {

struct Point {
  double x = 0;
  double y = 0;
};

// Where the pinhole ray (x, y, 1) lands: OpenCV's model (calib3d, "Detailed Description"), after Brown 1966.
Point distort(const Distortion& distortion, Point p) {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = distortion.coefficients;
  const double r2 = p.x * p.x + p.y * p.y;
  const double radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
  return {p.x * radial + 2 * p1 * p.x * p.y + p2 * (r2 + 2 * p.x * p.x),
          p.y * radial + p1 * (r2 + 2 * p.y * p.y) + 2 * p2 * p.x * p.y};
}

}  // namespace

bool Distortion::any() const {
  for (const double c : coefficients)
    if (c != 0) return true;
  return false;
}

Result<std::vector<std::int32_t>> undistortion_table(const Intrinsics& k, const Distortion& distortion,
                                                     const std::string& what) {
  for (const double c : distortion.coefficients)
    if (!std::isfinite(c))
      return Error{ErrorCode::invalid_argument, what + ": distortion_coefficients hold a value that is no number"};
  std::vector<std::int32_t> table(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height), -1);
  std::size_t seen_count = 0;
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const double fx = static_cast<double>(k.fx), fy = static_cast<double>(k.fy);
      const double cx = static_cast<double>(k.cx), cy = static_cast<double>(k.cy);
      const Point at = distort(distortion, {(u - cx) / fx, (v - cy) / fy});
      const double column = at.x * fx + cx + 0.5;
      const double row = at.y * fy + cy + 0.5;
      if (!(column >= 0 && column < k.width && row >= 0 && row < k.height)) continue;  // also when not a number
      table[static_cast<std::size_t>(v) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(u)] =
          static_cast<std::int32_t>(row) * k.width + static_cast<std::int32_t>(column);
      ++seen_count;
    }
  }
  if (seen_count * 2 < table.size())
    return Error{ErrorCode::invalid_argument,
                 what + ": distortion_coefficients leave " + std::to_string(seen_count * 100 / table.size()) +
                     " % of the picture, expected at least 50 %; calibrate the camera again"};
  return table;
}

}  // namespace im2fit::hal
