// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include <cstddef>

#include "kernels/blend/blend.h"

namespace im2fit {
namespace {

inline float32x4_t moved(const float* value, int16x4_t delta, float scale) {
  return vaddq_f32(vld1q_f32(value), vmulq_n_f32(vcvtq_f32_s32(vmovl_s16(delta)), scale));
}
inline void move_eight(float* value, int16x8_t delta, float scale) {
  const float32x4_t low = moved(value, vget_low_s16(delta), scale);
  const float32x4_t high = moved(value + 4, vget_high_s16(delta), scale);
  vst1q_f32(value, low);
  vst1q_f32(value + 4, high);
}

constexpr std::int16_t kKept[16] = {0, 0, 0, 0, 0, 0, 0, 0, -1, -1, -1, -1, -1, -1, -1, -1};
constexpr std::int16_t kLastTwo[4] = {0, 0, -1, -1};

// The rest of a run is done with the vector that ends where the run ends; lanes that were done before get a delta of
// 0. That changes no bit: x + 0 scale is x, and of the zeros -0 arises only where scale is negative and 0 scale is
// -0.
void blend_one(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto& into) {
  const float scale = into.scale;
  for (const BlendRun* run = runs; run != runs + run_count; ++run) {
    float* value = into.vertices + std::ptrdiff_t{run->first_vertex} * 3;
    const std::int16_t* delta = deltas + static_cast<std::ptrdiff_t>(run->first_delta) * 3;
    const int count = run->vertex_count * 3;
    if (count >= 8) {
      int i = 0;
      for (; i + 16 <= count; i += 16) {
        const int16x8_t first = vld1q_s16(delta + i), second = vld1q_s16(delta + i + 8);
        move_eight(value + i, first, scale);
        move_eight(value + i + 8, second, scale);
      }
      for (; i + 8 <= count; i += 8) move_eight(value + i, vld1q_s16(delta + i), scale);
      if (i == count) continue;
      const int16x8_t rest = vandq_s16(vld1q_s16(delta + count - 8), vld1q_s16(kKept + (count - i)));
      move_eight(value + count - 8, rest, scale);
    } else if (count == 6) {
      vst1q_f32(value, moved(value, vld1_s16(delta), scale));
      vst1q_f32(value + 2, moved(value + 2, vand_s16(vld1_s16(delta + 2), vld1_s16(kLastTwo)), scale));
    } else if (count == 3) {
      for (int i = 0; i < 3; ++i) value[i] += scale * static_cast<float>(delta[i]);
    }
  }
}

}  // namespace

// One mesh after the other: their deltas are the same, but a tablet's cores read ahead well enough.
void blend_neon(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto* into,
                int into_count) {
  for (int m = 0; m < into_count; ++m) blend_one(runs, run_count, deltas, into[m]);
}

}  // namespace im2fit
