// SPDX-License-Identifier: Apache-2.0
// Linear blend skinning: a vertex follows up to four segments, each by its weight.
#pragma once

#include <array>
#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

struct SkinRecord {  // heaviest first; weights sum to 1; unused places have weight 0
  std::array<std::uint8_t, 4> segment{};
  std::array<float, 4> weight{};
};
static_assert(sizeof(SkinRecord) == 20);

// Where a segment takes a point: x * column[0] + y * column[1] + z * column[2] + column[3]. Fourth values are 0.
struct alignas(16) SkinMatrix {
  float column[4][4];
};

// For each vertex (x, y, z one after another): the sum of (((x c0 + y c1) + z c2) + c3) * weight, first segment
// first, up to the first weight that is not positive (the first segment always counts). float32 in that order.
// Portable is within 12 roundings of the largest term of ref. ARMv7 runs portable: rotations hold products of small
// numbers, and its vectors would take denormal ones for zero. No allocation, thread-safe; `out` is not `vertices`.
using SkinFunction = void(const float* vertices, const SkinRecord* records, int vertex_count,
                          const SkinMatrix* matrices, float* out);
SkinFunction skin_portable, skin_neon, skin_avx2, skin;

inline constexpr KernelVariant<SkinFunction> kSkinKernels[] = {IM2FIT_PORTABLE(skin) IM2FIT_NEON64(skin)
                                                                   IM2FIT_AVX2(skin)};

}  // namespace im2fit
