// SPDX-License-Identifier: Apache-2.0
// A picture laid on a surface, decoded from PNG.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/status.h"

namespace im2fit {

class Texture {
 public:
  // At most body::kTextureSideMax pixels a side. Errors: corrupt.
  static Result<Texture> decode(std::span<const std::byte> png);
  // Linear light, 0..1, between the four nearest pixels. `u`, `v`: 0..1, v downwards; beyond, the edge goes on.
  std::array<float, 3> at(float u, float v) const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<std::uint8_t> rgb_;
};

}  // namespace im2fit
