// SPDX-License-Identifier: Apache-2.0
// A sparse shape target onto a mesh: runs of vertices, each moved by a stored step times a weight.
#pragma once

#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

struct BlendRun {                 // consecutive vertices of one target
  std::uint32_t first_delta = 0;  // in vertices (three int16 each)
  std::uint16_t first_vertex = 0;
  std::uint16_t vertex_count = 0;
};
static_assert(sizeof(BlendRun) == 8);

// The least scale that counts: with it, no product and no sum is a denormal float (vertices being 0 or above 2^-60),
// so that ARMv7, whose vectors take those for zero, gives the same bits.
inline constexpr float kBlendScaleMin = 0x1p-96F;

// A mesh that the target moves by its own weight: x, y and z of each vertex.
struct BlendInto {
  float scale;
  float* vertices;
};
inline constexpr int kBlendIntoMax = 3;

// vertex[i] += scale * delta[i], x, y and z of each vertex of each run, in each of the `into_count` meshes (none of
// them twice): float32, the product rounded, then the sum. Several meshes at once, since the deltas come from far: a
// body has 3 MB of them at work. Why no fixed point: a body is solved for by moving its sliders until stature and
// weight fit to a thousandth of a millimetre, and a weight rounded to 16 bits would make stairs of 0.01 mm. |scale|
// >= kBlendScaleMin. Portable is within 2 roundings of ref: (|scale delta| + |result|) 2^-24. No allocation,
// thread-safe for distinct vertices.
using BlendFunction = void(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto* into,
                           int into_count);
BlendFunction blend_portable, blend_neon, blend_avx2, blend;

inline constexpr KernelVariant<BlendFunction> kBlendKernels[] = {IM2FIT_PORTABLE(blend) IM2FIT_NEON(blend)
                                                                     IM2FIT_AVX2(blend)};

}  // namespace im2fit
