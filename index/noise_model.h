// SPDX-License-Identifier: Apache-2.0
// How errors of answers grow with the conditions of a capture: few frames, a large distance, and clothes unlike those
// of the training data make them larger.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/guidance.h"

namespace im2fit::index {

// From here on errors grow with distance. Up to here a sensor's steps are small beside what shape leaves open.
inline constexpr double kWellSeenMm = 2500;

// The terms of an error's variance: 1; 1/(frames + 1); d^2, with d the distance beyond kWellSeenMm in units of
// kWellSeenMm; d^2/(frames + 1); and the mean square of the seen values in standard deviations of the training people
// (ValueMap::novelty; of people in clothes, else 0). frames + 1, because the law is fitted to people seen in 3 frames
// or more and must hold for one frame as well (docs/formats-index.md). Fewer than one frame count as one. A distance
// of 0 or less is unknown and treated as the farthest at which people are measured.
inline constexpr std::size_t kNoiseTerms = 5;
inline std::array<double, kNoiseTerms> noise_terms(int frame_count, int distance_mm, double novelty) {
  const double beyond = std::max((distance_mm > 0 ? distance_mm : kTooFarMm) / kWellSeenMm - 1, 0.0);
  const double per_frame = 1.0 / (std::max(frame_count, 1) + 1);
  return {1, per_frame, beyond * beyond, beyond * beyond * per_frame, novelty};
}

// Of the file; fixed layout.
struct NoiseModel {
  // Variance for each of the terms, relative to its mean over those it was fitted to.
  std::array<double, kNoiseTerms> share = {1};

  // Standard deviation, relative as well.
  double width(int frame_count, int distance_mm, double novelty = 0) const {
    const auto terms = noise_terms(frame_count, distance_mm, novelty);
    double variance = 0;
    for (std::size_t i = 0; i < kNoiseTerms; ++i) variance += share[i] * terms[i];
    return std::sqrt(variance);
  }
};

}  // namespace im2fit::index
