// SPDX-License-Identifier: Apache-2.0
// The extents of a surface's triangles along an axis, in blocks of consecutive ones, neighbours mostly: the triangles
// that a level crosses are found without checking all of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace im2fit::body {

class IntervalBlocks {
 public:
  void clear() {
    intervals_.clear();
    blocks_.clear();
  }
  void reserve(std::size_t count) {
    intervals_.reserve(count);
    blocks_.reserve(count / kBlock + 1);
  }
  void add(float low, float high) {
    if (intervals_.size() % kBlock == 0) blocks_.push_back({low, high});
    Interval& block = blocks_.back();
    block = {std::min(block.low, low), std::max(block.high, high)};
    intervals_.push_back({low, high});
  }
  // Calls visit(i) in order with each interval that begins at or below the level and ends above it.
  template <class F>
  void at_level(float level, F visit) const {
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (!blocks_[b].crosses(level)) continue;
      const std::size_t end = std::min((b + 1) * kBlock, intervals_.size());
      for (std::size_t i = b * kBlock; i < end; ++i)
        if (intervals_[i].crosses(level)) visit(i);
    }
  }

 private:
  static constexpr std::size_t kBlock = 16;
  struct Interval {
    float low, high;
    bool crosses(float level) const { return high - level > 0 && !(low - level > 0); }
  };
  std::vector<Interval> intervals_, blocks_;
};

}  // namespace im2fit::body
