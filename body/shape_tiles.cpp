// SPDX-License-Identifier: Apache-2.0
#include "body/shape_tiles.h"

#include <cstring>

namespace im2fit::body {
namespace {

using Steps = std::int16_t __attribute__((vector_size(16)));
using Whole = std::int32_t __attribute__((vector_size(16)));
using Real = float __attribute__((vector_size(16)));
using Tile = std::array<Steps, kShapeTile>;

Steps low_halves(Steps a, Steps b) {
  return __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
}
Steps high_halves(Steps a, Steps b) {
  return __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
}

// Rows become columns: three rounds of a perfect shuffle.
void turn(Tile& rows) {
  for (int round = 0; round < 3; ++round) {
    const Tile before = rows;
    for (std::size_t i = 0; i < kShapeTile / 2; ++i) {
      rows[2 * i] = low_halves(before[i], before[i + kShapeTile / 2]);
      rows[2 * i + 1] = high_halves(before[i], before[i + kShapeTile / 2]);
    }
  }
}

// Little-endian: a step, and what its sign makes of the upper half, are a whole number of 32 bits.
void put_scaled(Steps halves, const float* scale, float* out) {
  Real scales;
  std::memcpy(&scales, scale, sizeof scales);
  scales *= __builtin_convertvector(reinterpret_cast<Whole>(halves), Real);
  std::memcpy(out, &scales, sizeof scales);
}

}  // namespace

void unpack_tiles(const std::int16_t* steps, std::size_t stride, std::size_t planes,
                  const std::array<const float*, kShapeTile>& scale, float* out) {
  std::size_t plane = 0;
  for (; plane + kShapeTile <= planes; plane += kShapeTile) {
    Tile tile;
    for (std::size_t p = 0; p < kShapeTile; ++p) std::memcpy(&tile[p], steps + (plane + p) * stride, sizeof tile[p]);
    turn(tile);
    for (std::size_t v = 0; v < kShapeTile; ++v) {
      const Steps negative = tile[v] < 0;
      float* to = out + v * planes + plane;
      put_scaled(low_halves(tile[v], negative), scale[v] + plane, to);
      put_scaled(high_halves(tile[v], negative), scale[v] + plane + kShapeTile / 2, to + kShapeTile / 2);
    }
  }
  for (; plane < planes; ++plane)
    for (std::size_t v = 0; v < kShapeTile; ++v)
      out[v * planes + plane] = static_cast<float>(steps[plane * stride + v]) * scale[v][plane];
}

}  // namespace im2fit::body
