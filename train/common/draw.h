// SPDX-License-Identifier: Apache-2.0
// Draws of floats.
#pragma once

#include "core/rng.h"

namespace im2fit::lab {

inline float draw(Rng& rng, double low, double high) {
  return static_cast<float>(rng.uniform(low, high));
}

}  // namespace im2fit::lab
