// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace im2fit::body::makehuman {

// 0 at `from`, 1 at `to`, level at both ends; `from` may be the larger.
inline float smooth(float v, float from, float to) {
  const float t = std::clamp((v - from) / (to - from), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

}  // namespace im2fit::body::makehuman
