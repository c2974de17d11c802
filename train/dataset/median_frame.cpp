// SPDX-License-Identifier: Apache-2.0
#include "train/dataset/median_frame.h"

#include <algorithm>
#include <cstddef>

#include "kernels/average/average.h"
#include "train/common/simd_clones.h"

namespace im2fit::lab {
namespace {

// Written so that the vectoriser takes them: it does not vectorise std::min here.

// No data, 0, becomes the largest value and back; modulo 2^16.
IM2FIT_SIMD_CLONES void shift_row(const std::uint16_t* __restrict in, std::uint16_t by, int count,
                                  std::uint16_t* __restrict out) {
  for (int i = 0; i < count; ++i) out[i] = static_cast<std::uint16_t>(in[i] + by);
}

// The smaller of each pair into `low`.
IM2FIT_SIMD_CLONES void order_rows(std::uint16_t* __restrict low, std::uint16_t* __restrict high, int count) {
  for (int i = 0; i < count; ++i) {
    const std::uint16_t a = low[i], b = high[i];
    const std::uint16_t least = a < b ? a : b, most = a < b ? b : a;
    low[i] = least;
    high[i] = most;
  }
}

IM2FIT_SIMD_CLONES void near_row(const std::uint16_t* __restrict frame, const std::uint16_t* __restrict median,
                                 const std::uint8_t* __restrict mask, int count, std::uint8_t* __restrict out) {
  constexpr auto kReach = static_cast<std::uint16_t>(kOutlierMm);
  for (int i = 0; i < count; ++i) {
    const std::uint16_t a = frame[i], b = median[i];
    const auto off = static_cast<std::uint16_t>(a < b ? b - a : a - b);
    const std::uint8_t near = off <= kReach ? 0xFF : 0;
    out[i] = mask[i] & near;
  }
}

}  // namespace

void MedianFrame::run(std::span<const DepthView> frames, DepthImage out) {
  const std::size_t count = frames.size(), middle = (count - 1) / 2;
  const auto stride = static_cast<std::size_t>(out.width);
  rows_.resize(stride * count);
  const auto row = [&](std::size_t i) { return rows_.data() + i * stride; };
  for (int v = 0; v < out.height; ++v) {
    for (std::size_t f = 0; f < count; ++f) shift_row(frames[f].row(v), 0xFFFF, out.width, row(f));
    for (std::size_t i = 0; i <= middle; ++i)
      for (std::size_t j = count - 1; j > i; --j) order_rows(row(j - 1), row(j), out.width);
    shift_row(row(middle), 1, out.width, out.row(v));
  }
}

void mask_near(DepthView frame, DepthView median, MaskView mask, MaskImage out) {
  for (int v = 0; v < out.height; ++v) near_row(frame.row(v), median.row(v), mask.row(v), out.width, out.row(v));
}

}  // namespace im2fit::lab
