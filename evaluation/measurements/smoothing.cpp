// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/smoothing.h"

#include <cmath>

#include "kernels/average/average.h"

namespace im2fit::lab {

void TemporalSmoothing::run(DepthImage frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  smooth_mm_.resize(width * static_cast<std::size_t>(frame.height));
  for (int v = 0; v < frame.height; ++v) {
    std::uint16_t* row = frame.row(v);
    float* smooth = smooth_mm_.data() + static_cast<std::size_t>(v) * width;
    for (std::size_t u = 0; u < width; ++u) {
      const auto now = static_cast<float>(row[u]);
      const float step = now - smooth[u];
      const bool same = row[u] != 0 && smooth[u] > 0 && std::fabs(step) <= static_cast<float>(kOutlierMm);
      smooth[u] = same ? smooth[u] + kShare * step : now;
      row[u] = static_cast<std::uint16_t>(std::lround(smooth[u]));
    }
  }
}

}  // namespace im2fit::lab
