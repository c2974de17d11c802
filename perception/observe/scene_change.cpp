// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/scene_change.h"

#include <algorithm>
#include <cstddef>

// The thresholds of this file.
namespace im2fit::scene_change_limits {

// Sampled pixels along the long side: every eighth of 640, a finger's breadth apart at 1 m, 55 mm at 4 m.
constexpr int kLookedAtLong = 80;
// Sampled pixels of a block, a side: at 4 m a block is 220 mm wide, the breadth of a head or of two limbs.
constexpr int kBlockSide = 4;
constexpr int kChangedMin = kBlockSide * kBlockSide / 2;
// A Kinect's depth scatters by 1.4e-6 z^2 (SD in mm, z in mm; Khoshelham and Elberink 2012): the difference of two
// pictures stays within five of its SD, and within the few centimetres by which a person sways.
constexpr int kToleranceMm = 60;
constexpr int kToleranceDivisor = 100'000;  // of z^2: 22 mm at 1.5 m, 160 mm at 4 m

}  // namespace im2fit::scene_change_limits

namespace im2fit {

using namespace scene_change_limits;

SceneChange::SceneChange(int width, int height)
    : step_px_(std::max(1, std::max(width, height) / kLookedAtLong)),
      columns_(width / step_px_),
      rows_(height / step_px_),
      ranges_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
      counts_(static_cast<std::size_t>((columns_ + kBlockSide - 1) / kBlockSide)) {}

void SceneChange::keep(DepthView depth) {
  kept_ = true;
  std::size_t i = 0;
  for (int r = 0; r < rows_; ++r) {
    const std::uint16_t* row = depth.row(r * step_px_);
    for (int c = 0; c < columns_; ++c) {
      const int z = row[c * step_px_];
      // No data is a range of its own.
      const std::int64_t tolerance = kToleranceMm + static_cast<std::int64_t>(z) * z / kToleranceDivisor;
      const auto least = z == 0 ? 0 : std::max<std::int64_t>(1, z - tolerance);
      const auto most = z == 0 ? 0 : std::min<std::int64_t>(UINT16_MAX, z + tolerance);
      ranges_[i++] = {static_cast<std::uint16_t>(least), static_cast<std::uint16_t>(most - least)};
    }
  }
}

bool SceneChange::changed(DepthView depth) const {
  if (!kept_) return true;
  const Range* range = ranges_.data();
  for (int r0 = 0; r0 < rows_; r0 += kBlockSide) {
    std::fill(counts_.begin(), counts_.end(), std::uint8_t{0});
    for (int r = r0; r < std::min(rows_, r0 + kBlockSide); ++r) {
      const std::uint16_t* pixel = depth.row(r * step_px_);
      const auto moved = [&](int i) {
        return static_cast<std::uint16_t>(pixel[i * step_px_] - range[i].least_mm) > range[i].span_mm ? 1 : 0;
      };
      int block = 0;
      for (; (block + 1) * kBlockSide <= columns_; ++block, range += kBlockSide, pixel += kBlockSide * step_px_) {
        int count = 0;
        for (int i = 0; i < kBlockSide; ++i) count += moved(i);
        counts_[static_cast<std::size_t>(block)] =
            static_cast<std::uint8_t>(counts_[static_cast<std::size_t>(block)] + count);
      }
      for (int i = 0; i < columns_ - block * kBlockSide; ++i)
        if (moved(i) != 0) ++counts_[static_cast<std::size_t>(block)];
      range += columns_ - block * kBlockSide;
    }
    if (std::any_of(counts_.begin(), counts_.end(), [](std::uint8_t count) { return count >= kChangedMin; }))
      return true;
  }
  return false;
}

}  // namespace im2fit
