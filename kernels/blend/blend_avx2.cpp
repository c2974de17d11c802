// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include <cstddef>

#include "kernels/blend/blend.h"

namespace im2fit {
namespace {

inline void move_eight(float* value, __m128i delta, __m256 scale) {
  const __m256 step = _mm256_mul_ps(scale, _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(delta)));
  _mm256_storeu_ps(value, _mm256_add_ps(_mm256_loadu_ps(value), step));
}
inline __m128i eight(const std::int16_t* delta) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(delta));
}
inline void move_four(float* value, __m128i delta, __m128 scale) {
  const __m128 step = _mm_mul_ps(scale, _mm_cvtepi32_ps(_mm_cvtepi16_epi32(delta)));
  _mm_storeu_ps(value, _mm_add_ps(_mm_loadu_ps(value), step));
}
inline __m128i four(const std::int16_t* delta) {
  return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(delta));
}

alignas(32) constexpr std::int16_t kKept[16] = {0, 0, 0, 0, 0, 0, 0, 0, -1, -1, -1, -1, -1, -1, -1, -1};

}  // namespace

// The rest of a run is done with the vector that ends where the run ends; lanes that were done before get a delta of
// 0. That changes no bit: x + 0 scale is x, and of the zeros -0 arises only where scale is negative and 0 scale is
// -0.
void blend_avx2(const BlendRun* runs, int run_count, const std::int16_t* deltas, float scale, float* vertices) {
  const __m256 scale8 = _mm256_set1_ps(scale);
  const __m128 scale4 = _mm256_castps256_ps128(scale8);
  for (const BlendRun* run = runs; run != runs + run_count; ++run) {
    float* value = vertices + std::ptrdiff_t{run->first_vertex} * 3;
    const std::int16_t* delta = deltas + static_cast<std::ptrdiff_t>(run->first_delta) * 3;
    const int count = run->vertex_count * 3;
    if (count >= 8) {
      int i = 0;
      for (; i + 8 <= count; i += 8) move_eight(value + i, eight(delta + i), scale8);
      if (i == count) continue;
      const __m128i kept = _mm_loadu_si128(reinterpret_cast<const __m128i*>(kKept + (count - i)));
      move_eight(value + count - 8, _mm_and_si128(eight(delta + count - 8), kept), scale8);
    } else if (count == 6) {
      move_four(value, four(delta), scale4);
      move_four(value + 2, _mm_and_si128(four(delta + 2), _mm_set_epi16(0, 0, 0, 0, -1, -1, 0, 0)), scale4);
    } else if (count == 3) {
      for (int i = 0; i < 3; ++i) value[i] += scale * static_cast<float>(delta[i]);
    }
  }
}

}  // namespace im2fit
