// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include <cstddef>

#include "kernels/blend/blend.h"

namespace im2fit {
namespace {

inline __m128i eight(const std::int16_t* delta) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(delta));
}
inline __m128i four(const std::int16_t* delta) {
  return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(delta));
}

alignas(32) constexpr std::int16_t kKept[16] = {0, 0, 0, 0, 0, 0, 0, 0, -1, -1, -1, -1, -1, -1, -1, -1};

// kCount meshes' steps of the same deltas.
template <int kCount>
struct Movers {
  explicit Movers(const BlendInto* into) {
    for (int m = 0; m < kCount; ++m) {
      vertices[m] = into[m].vertices;
      scale[m] = _mm256_set1_ps(into[m].scale);
    }
  }
  void move_eight(std::ptrdiff_t at, __m128i delta) const {
    const __m256 exact = _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(delta));
    for (int m = 0; m < kCount; ++m) {
      float* value = vertices[m] + at;
      _mm256_storeu_ps(value, _mm256_add_ps(_mm256_loadu_ps(value), _mm256_mul_ps(scale[m], exact)));
    }
  }
  void move_four(std::ptrdiff_t at, __m128i delta) const {
    const __m128 exact = _mm_cvtepi32_ps(_mm_cvtepi16_epi32(delta));
    for (int m = 0; m < kCount; ++m) {
      float* value = vertices[m] + at;
      const __m128 step = _mm_mul_ps(_mm256_castps256_ps128(scale[m]), exact);
      _mm_storeu_ps(value, _mm_add_ps(_mm_loadu_ps(value), step));
    }
  }
  void move_one(std::ptrdiff_t at, std::int16_t delta) const {
    for (int m = 0; m < kCount; ++m) vertices[m][at] += _mm256_cvtss_f32(scale[m]) * static_cast<float>(delta);
  }
  float* vertices[kCount];
  __m256 scale[kCount];
};

// The rest of a run is done with the vector that ends where the run ends; lanes that were done before get a delta of
// 0. That changes no bit: x + 0 scale is x, and of the zeros -0 arises only where scale is negative and 0 scale is
// -0.
template <int kCount>
void blend_into(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto* into) {
  const Movers<kCount> movers(into);
  for (const BlendRun* run = runs; run != runs + run_count; ++run) {
    const std::ptrdiff_t at = std::ptrdiff_t{run->first_vertex} * 3;
    const std::int16_t* delta = deltas + static_cast<std::ptrdiff_t>(run->first_delta) * 3;
    const int count = run->vertex_count * 3;
    if (count >= 8) {
      int i = 0;
      for (; i + 8 <= count; i += 8) movers.move_eight(at + i, eight(delta + i));
      if (i == count) continue;
      const __m128i kept = _mm_loadu_si128(reinterpret_cast<const __m128i*>(kKept + (count - i)));
      movers.move_eight(at + count - 8, _mm_and_si128(eight(delta + count - 8), kept));
    } else if (count == 6) {
      movers.move_four(at, four(delta));
      movers.move_four(at + 2, _mm_and_si128(four(delta + 2), _mm_set_epi16(0, 0, 0, 0, -1, -1, 0, 0)));
    } else if (count == 3) {
      for (int i = 0; i < 3; ++i) movers.move_one(at + i, delta[i]);
    }
  }
}

}  // namespace

void blend_avx2(const BlendRun* runs, int run_count, const std::int16_t* deltas, const BlendInto* into,
                int into_count) {
  switch (into_count) {
    case 1:
      return blend_into<1>(runs, run_count, deltas, into);
    case 2:
      return blend_into<2>(runs, run_count, deltas, into);
    case 3:
      return blend_into<3>(runs, run_count, deltas, into);
    default:
      return;
  }
}

}  // namespace im2fit
