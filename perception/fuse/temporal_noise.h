// SPDX-License-Identifier: Apache-2.0
// How noisy a sensor is, from frames of a person who stands still: outlines, and so widths and girths, come out
// otherwise of a sensor without noise than of a Kinect, and the index must know which it answers.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"

namespace im2fit {

// Mean absolute difference between a masked pixel's depth and the one it had when it was masked last, on every
// kRowStep-th row: thousands of pixels of a person, and half a percent of the frame's time. Differences beyond
// kOutlierMm are another surface's, and a frame equal to the one before is skipped once others differed.
// Integers until the last division: the same bits on every machine. No allocation after construction; not shareable
// between threads.
class TemporalNoise {
 public:
  static constexpr int kRowStep = 8;
  TemporalNoise(int width, int height);
  void reset();
  // The masked pixels inside the inclusive box, as DepthFusion::add().
  void add(DepthView depth, MaskView mask, int u_min, int v_min, int u_max, int v_max);
  // Standard deviation of a pixel of one frame, mm, as of normal noise: of two such values the mean absolute
  // difference is 2/sqrt(pi) times it. NaN until frames share kPairsMin pixels.
  static constexpr std::uint64_t kPairsMin = 50;
  float sd_mm() const;

 private:
  int width_, height_;
  std::uint64_t difference_sum_mm_ = 0;
  std::uint64_t pairs_ = 0;
  std::uint64_t repeated_pairs_ = 0;        // of frames that differed nowhere
  std::vector<std::uint16_t> previous_mm_;  // of the rows sampled; 0: not masked yet
};

}  // namespace im2fit
