// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/standardise/standardise_one.h"

namespace im2fit {
namespace {

// Eight whole numbers. The conversion rounds ties to even, as the addition in standardise_one does.
inline __m256i eight(const float* feature, const float* mean, const float* scale) {
  __m256 z = _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(feature), _mm256_loadu_ps(mean)), _mm256_loadu_ps(scale));
  z = _mm256_and_ps(z, _mm256_cmp_ps(z, z, _CMP_ORD_Q));
  z = _mm256_min_ps(z, _mm256_set1_ps(kStandardFeatureMax));
  z = _mm256_max_ps(z, _mm256_set1_ps(-kStandardFeatureMax));
  return _mm256_cvtps_epi32(_mm256_mul_ps(z, _mm256_set1_ps(4096.0F)));
}

}  // namespace

void standardise_avx2(const float* feature, const float* mean, const float* scale, int count, std::int16_t* out) {
  int i = 0;
  for (; i + 16 <= count; i += 16) {
    const __m256i packed = _mm256_packs_epi32(eight(feature + i, mean + i, scale + i),
                                              eight(feature + i + 8, mean + i + 8, scale + i + 8));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + i), _mm256_permute4x64_epi64(packed, 0xD8));
  }
  for (; i < count; ++i) out[i] = standardise_one(feature[i], mean[i], scale[i]);
}

}  // namespace im2fit
