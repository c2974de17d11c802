// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/skin/skin.h"

namespace im2fit {
namespace {

inline __m128 moved(const SkinMatrix* m, __m128 x, __m128 y, __m128 z, const float* weight) {
  const float* c = m->column[0];
  const __m128 xy = _mm_add_ps(_mm_mul_ps(_mm_load_ps(c), x), _mm_mul_ps(_mm_load_ps(c + 4), y));
  const __m128 p = _mm_add_ps(_mm_add_ps(xy, _mm_mul_ps(_mm_load_ps(c + 8), z)), _mm_load_ps(c + 12));
  return _mm_mul_ps(p, _mm_broadcast_ss(weight));
}

}  // namespace

// A vertex a vector, x, y and z side by side: most vertices follow one segment, and neighbours the same, so that more
// vertices at once would mostly gather what lies together anyway.
void skin_avx2(const float* vertices, const SkinRecord* records, int vertex_count, const SkinMatrix* matrices,
               float* out) {
  for (int v = 0; v < vertex_count; ++v, vertices += 3, out += 3) {
    const std::uint8_t* segment = reinterpret_cast<const std::uint8_t*>(records + v);
    const float* weight = reinterpret_cast<const float*>(segment + 4);
    const __m128 x = _mm_broadcast_ss(vertices), y = _mm_broadcast_ss(vertices + 1),
                 z = _mm_broadcast_ss(vertices + 2);
    __m128 sum = moved(matrices + segment[0], x, y, z, weight);
    for (int i = 1; i < 4 && weight[i] > 0; ++i)
      sum = _mm_add_ps(sum, moved(matrices + segment[i], x, y, z, weight + i));
    if (v + 1 < vertex_count) {
      _mm_storeu_ps(out, sum);  // the fourth value is overwritten by the next vertex
    } else {
      _mm_storel_pi(reinterpret_cast<__m64*>(out), sum);
      _mm_store_ss(out + 2, _mm_movehl_ps(sum, sum));
    }
  }
}

}  // namespace im2fit
