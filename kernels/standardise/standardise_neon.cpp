// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/standardise/standardise_one.h"

namespace im2fit {
namespace {

// ARMv7 takes denormal floats for zero: see the header why that changes nothing here.
inline int16x4_t four(const float* feature, const float* mean, const float* scale) {
  float32x4_t z = vmulq_f32(vsubq_f32(vld1q_f32(feature), vld1q_f32(mean)), vld1q_f32(scale));
  z = vreinterpretq_f32_u32(vandq_u32(vreinterpretq_u32_f32(z), vceqq_f32(z, z)));
  z = vmaxq_f32(vminq_f32(z, vdupq_n_f32(kStandardFeatureMax)), vdupq_n_f32(-kStandardFeatureMax));
  const float32x4_t whole = vdupq_n_f32(12582912.0F);
  const float32x4_t rounded = vsubq_f32(vaddq_f32(vmulq_f32(z, vdupq_n_f32(4096.0F)), whole), whole);
  return vmovn_s32(vcvtq_s32_f32(rounded));
}

}  // namespace

void standardise_neon(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  int i = 0;
  for (; i + 8 <= count; i += 8) {
    vst1q_s16(out + i, vcombine_s16(four(feature + i, mean + i, scale + i),
                                    four(feature + i + 4, mean + i + 4, scale + i + 4)));
  }
  for (; i < count; ++i) out[i] = standardise_one(feature[i], mean[i], scale[i]);
}

}  // namespace im2fit
