// SPDX-License-Identifier: Apache-2.0
#include "perception/fuse/temporal_noise.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numbers>

#include "kernels/average/average.h"

namespace im2fit {
namespace {

struct Row {
  std::uint32_t difference_sum_mm, pairs;
};

// Without branches and in whole words, for the vectoriser.
Row compare(const std::uint16_t* __restrict depth, const std::uint8_t* __restrict mask, int count,
            std::uint16_t* __restrict previous) {
  std::int32_t sum = 0, pairs = 0;
  for (int u = 0; u < count; ++u) {
    const std::int32_t before = previous[u], seen = depth[u];
    const std::int32_t now = seen & -static_cast<std::int32_t>(mask[u] == 255);
    const std::int32_t difference = before > now ? before - now : now - before;
    const std::int32_t close = static_cast<std::int32_t>(difference <= static_cast<std::int32_t>(kOutlierMm));
    const std::int32_t both = close & static_cast<std::int32_t>(before != 0) & static_cast<std::int32_t>(now != 0);
    sum += difference & -both;
    pairs += both;
    previous[u] = static_cast<std::uint16_t>(now + (before & -static_cast<std::int32_t>(now == 0)));
  }
  return {static_cast<std::uint32_t>(sum), static_cast<std::uint32_t>(pairs)};
}

}  // namespace

TemporalNoise::TemporalNoise(int width, int height)
    : width_(width),
      height_(height),
      previous_mm_(static_cast<std::size_t>(width) * static_cast<std::size_t>((height + kRowStep - 1) / kRowStep)) {}

void TemporalNoise::reset() {
  difference_sum_mm_ = pairs_ = repeated_pairs_ = 0;
  std::fill(previous_mm_.begin(), previous_mm_.end(), std::uint16_t{0});
}

void TemporalNoise::add(DepthView depth, MaskView mask, int u_min, int v_min, int u_max, int v_max) {
  const int left = std::max(0, u_min);
  const int count = std::min(width_ - 1, u_max) - left + 1;
  std::uint64_t differences_mm = 0, pairs = 0;
  const int first = (std::max(0, v_min) + kRowStep - 1) / kRowStep;
  for (int i = first; count > 0 && i * kRowStep <= std::min(height_ - 1, v_max); ++i) {
    const int v = i * kRowStep;
    std::uint16_t* previous =
        previous_mm_.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(width_) + left;
    const Row row = compare(depth.row(v) + left, mask.row(v) + left, count, previous);
    differences_mm += row.difference_sum_mm;
    pairs += row.pairs;
  }
  difference_sum_mm_ += differences_mm;
  (differences_mm > 0 ? pairs_ : repeated_pairs_) += pairs;
}

float TemporalNoise::sd_mm() const {
  if (pairs_ < kPairsMin) return repeated_pairs_ < kPairsMin ? std::numeric_limits<float>::quiet_NaN() : 0.0F;
  constexpr double kSdPerDifference = 0.5 / std::numbers::inv_sqrtpi;
  return static_cast<float>(static_cast<double>(difference_sum_mm_) / static_cast<double>(pairs_) * kSdPerDifference);
}

}  // namespace im2fit
