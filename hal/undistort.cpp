// SPDX-License-Identifier: Apache-2.0
#include "hal/undistort.h"

#include <cmath>
#include <cstring>

namespace im2fit::hal {
namespace {

constexpr std::size_t kLeastSeenPercent = 50;
constexpr std::int32_t kBlock = 8;  // pixels in a register

}  // namespace

// OpenCV's model (calib3d, "Detailed Description"), after Brown 1966.
PicturePoint seen_at(const Intrinsics& k, const Distortion& distortion, double x, double y) {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = distortion.coefficients;
  const double r2 = x * x + y * y;
  const double radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
  const double distorted_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double distorted_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {distorted_x * static_cast<double>(k.fx) + static_cast<double>(k.cx),
          distorted_y * static_cast<double>(k.fy) + static_cast<double>(k.cy)};
}

std::int32_t pixel_at(const Intrinsics& k, const PicturePoint& point) {
  const double column = point.u + 0.5, row = point.v + 0.5;
  if (!(column >= 0 && column < k.width && row >= 0 && row < k.height)) return -1;  // also when not a number
  return static_cast<std::int32_t>(row) * k.width + static_cast<std::int32_t>(column);
}

bool Distortion::any() const {
  for (const double c : coefficients)
    if (c != 0) return true;
  return false;
}

Status check_seen(std::size_t seen_count, std::size_t pixel_count, const std::string& what) {
  if (seen_count * 100 >= pixel_count * kLeastSeenPercent) return Ok{};
  return Error{ErrorCode::invalid_argument, what + ": distortion_coefficients leave " +
                                                std::to_string(seen_count * 100 / pixel_count) +
                                                " % of the picture, expected at least " +
                                                std::to_string(kLeastSeenPercent) + " %; calibrate the camera again"};
}

Result<std::vector<std::int32_t>> undistortion_table(const Intrinsics& k, const Distortion& distortion,
                                                     const std::string& what) {
  for (const double c : distortion.coefficients)
    if (!std::isfinite(c))
      return Error{ErrorCode::invalid_argument, what + ": distortion_coefficients hold a value that is not a number"};
  std::vector<std::int32_t> table(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height), -1);
  std::size_t seen_count = 0;
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const double fx = static_cast<double>(k.fx), fy = static_cast<double>(k.fy);
      const double cx = static_cast<double>(k.cx), cy = static_cast<double>(k.cy);
      const std::int32_t from = pixel_at(k, seen_at(k, distortion, (u - cx) / fx, (v - cy) / fy));
      if (from < 0) continue;
      table[static_cast<std::size_t>(v) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(u)] = from;
      ++seen_count;
    }
  }
  if (auto ok = check_seen(seen_count, table.size(), what); !ok) return ok.error();
  return table;
}

std::vector<UndistortRun> undistort_runs(std::span<const std::int32_t> table) {
  std::vector<UndistortRun> runs;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const std::int32_t from = table[i] < 0 ? -1 : table[i];
    if (!runs.empty()) {
      UndistortRun& last = runs.back();
      const std::int32_t next = last.from < 0 ? -1 : last.from + last.count;
      if (from == next) {
        ++last.count;
        continue;
      }
    }
    runs.push_back({static_cast<std::int32_t>(i), from, 1});
  }
  return runs;
}

// Blocks may end past their run, as the next run writes there after; near the end of a picture they may not.
void undistort(const std::uint16_t* in, int pixels, std::span<const UndistortRun> runs, std::uint16_t* out) {
  for (const UndistortRun& run : runs) {
    std::uint16_t* to = out + run.to;
    if (run.from < 0) {
      std::memset(to, 0, static_cast<std::size_t>(run.count) * sizeof *to);
      continue;
    }
    const std::uint16_t* from = in + run.from;
    const std::int32_t room = pixels - (run.to > run.from ? run.to : run.from);
    std::int32_t k = 0;
    for (; k < run.count && k + kBlock <= room; k += kBlock) std::memcpy(to + k, from + k, kBlock * sizeof *to);
    for (; k < run.count; ++k) to[k] = from[k];
  }
}

}  // namespace im2fit::hal
