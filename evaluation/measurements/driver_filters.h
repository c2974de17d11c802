// SPDX-License-Identifier: Apache-2.0
// What phones and their drivers do to depth: beside edges values are blended across them and low confidence is
// dropped; many drivers can smooth over time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/camera.h"

namespace im2fit::lab {

// How a pixel's value is made of its neighbourhood.
enum class EdgeBlend {
  none,
  mean3,      // the mean of 3x3 pixels with data, as ARKit's maps look
  mean5,      // of 5x5
  gauss5,     // of 5x5, weighted by a normal of 1.2 px
  bilinear2,  // every second sample of every second row, interpolated: a sensor of half the resolution
  bilateral5  // of 5x5, weighted by normals of 1.5 px and of kRangeSdMm of the depth's difference
};

struct EdgeFilterOptions {
  EdgeBlend blend = EdgeBlend::none;
  bool drop = false;  // then pixels beside a step of more than kDropStep, whose confidence is low, have no data
};

// Pixels without data stay without.
class EdgeFilter {
 public:
  static constexpr float kRangeSdMm = 150;
  static constexpr float kDropStep = 0.05F;  // of the nearer depth, among the 3x3 pixels
  explicit EdgeFilter(const EdgeFilterOptions& options) : options_(options) {}
  // In place.
  void run(DepthImage frame);

 private:
  EdgeFilterOptions options_;
  std::vector<std::uint16_t> before_;
};

// Exponential smoothing, pixel by pixel: each frame moves the delivered depth by kShare of the difference, and a step
// beyond kOutlierMm, another surface, all of it. Pixels without data keep none, and their filter starts again.
class TemporalSmoothing {
 public:
  static constexpr float kShare = 0.25F;
  // In place; frames of one size.
  void run(DepthImage frame);

 private:
  std::vector<float> smooth_mm_;
};

}  // namespace im2fit::lab
