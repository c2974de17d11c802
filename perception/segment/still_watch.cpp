// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/still_watch.h"

#include <algorithm>

namespace im2fit::segment {

Vec3f StillWatch::place_mm(Vec3f middle_mm) {
  if (placed_ && norm(middle_mm - place_mm_) <= kMovedOnMm) return place_mm_;
  *this = {};
  placed_ = true;
  place_mm_ = middle_mm;
  return place_mm_;
}

void StillWatch::add(float depth_mm, float seconds) {
  sum_mm_ += depth_mm;
  ++count_;
  block_s_ += seconds;
  if (block_s_ < kBlockS) return;
  const float mean_mm = sum_mm_ / static_cast<float>(count_);
  now_ = {std::min(now_.low, mean_mm), std::max(now_.high, mean_mm)};
  span_s_ += block_s_;
  seconds_ = std::min(seconds_ + block_s_, kWatchedS);
  sum_mm_ = 0;
  count_ = 0;
  block_s_ = 0;
  if (span_s_ < kSpanS) return;
  before_ = now_;
  now_ = {};
  span_s_ = 0;
}

float StillWatch::spread_mm() const {
  return std::max(0.0F, std::max(now_.high, before_.high) - std::min(now_.low, before_.low));
}

}  // namespace im2fit::segment
