// SPDX-License-Identifier: Apache-2.0
#include "lab/dataset/median_frame.h"

#include <algorithm>
#include <cstddef>

#include "kernels/average/average.h"
#include "lab/simd_clones.h"

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

// By forgetting: of one more than half of the values neither the least nor the most is the median. They go, the next
// value comes, and so on until three are left. Half the exchanges of sorting the lower half.
void MedianFrame::run(std::span<const DepthView> frames, DepthImage out) {
  const std::size_t count = frames.size();
  const auto stride = static_cast<std::size_t>(out.width);
  rows_.resize(stride * count);
  for (int v = 0; v < out.height; ++v) {
    left_.clear();
    for (std::size_t f = 0; f < count; ++f) {
      left_.push_back(rows_.data() + f * stride);
      shift_row(frames[f].row(v), 0xFFFF, out.width, left_.back());
    }
    // Of an even count the lower of the two in the middle: as if one more frame had seen the least there is.
    if (count % 2 == 0) {
      least_.assign(stride, 0);
      left_.push_back(least_.data());
    }
    std::size_t next = left_.size();  // of those still to come the last comes first
    // The set is at the front.
    for (std::size_t size = (left_.size() + 1) / 2 + 1; size >= 3; --size) {
      for (std::size_t i = 0; i < size / 2; ++i) order_rows(left_[i], left_[size - 1 - i], out.width);
      for (std::size_t i = 1; i < (size + 1) / 2; ++i) order_rows(left_[0], left_[i], out.width);
      for (std::size_t i = size / 2; i < size - 1; ++i) order_rows(left_[i], left_[size - 1], out.width);
      left_[0] = left_[--next];
    }
    shift_row(left_[count > 1 ? 1 : 0], 1, out.width, out.row(v));
  }
}

void mask_near(DepthView frame, DepthView median, MaskView mask, MaskImage out) {
  for (int v = 0; v < out.height; ++v) near_row(frame.row(v), median.row(v), mask.row(v), out.width, out.row(v));
}

}  // namespace im2fit::lab
