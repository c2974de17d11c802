// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/skin/skin.h"

namespace im2fit {
namespace {

struct Record {  // SkinRecord, without its arrays' functions
  std::uint8_t segment[4];
  float weight[4];
};
static_assert(sizeof(Record) == sizeof(SkinRecord));

inline __m128 moved(const SkinMatrix* m, __m128 x, __m128 y, __m128 z, const float* weight) {
  const float* c = m->column[0];
  const __m128 xy = _mm_add_ps(_mm_mul_ps(_mm_load_ps(c), x), _mm_mul_ps(_mm_load_ps(c + 4), y));
  const __m128 p = _mm_add_ps(_mm_add_ps(xy, _mm_mul_ps(_mm_load_ps(c + 8), z)), _mm_load_ps(c + 12));
  return _mm_mul_ps(p, _mm_broadcast_ss(weight));
}
// x, y and z side by side; the fourth value is 0.
inline __m128 skinned(const float* vertex, const Record* r, const SkinMatrix* matrices) {
  const __m128 x = _mm_broadcast_ss(vertex), y = _mm_broadcast_ss(vertex + 1), z = _mm_broadcast_ss(vertex + 2);
  __m128 sum = moved(matrices + r->segment[0], x, y, z, r->weight);
  for (int i = 1; i < 4 && r->weight[i] > 0; ++i)
    sum = _mm_add_ps(sum, moved(matrices + r->segment[i], x, y, z, r->weight + i));
  return sum;
}

inline bool only_follow(const Record* two, std::uint8_t segment) {
  return two[0].segment[0] == segment && two[1].segment[0] == segment && !(two[0].weight[1] > 0) &&
         !(two[1].weight[1] > 0);
}
inline __m256 side_by_side(const float* first, const float* second) {
  return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(first)), _mm_loadu_ps(second), 1);
}
// Two vertices at a time while they follow `segment` alone and a third is behind them: what is read and written past
// them is its own. Returns how many were done.
inline int skin_followers(const float* vertices, const Record* records, int count, const SkinMatrix* matrices,
                          std::uint8_t segment, float* out) {
  const __m128* c = reinterpret_cast<const __m128*>(matrices[segment].column[0]);
  const __m256 c0 = _mm256_broadcast_ps(c), c1 = _mm256_broadcast_ps(c + 1), c2 = _mm256_broadcast_ps(c + 2),
               c3 = _mm256_broadcast_ps(c + 3);
  int v = 0;
  for (; v + 2 < count && only_follow(records + v, segment); v += 2, vertices += 6, out += 6) {
    const __m256 p = side_by_side(vertices, vertices + 3);
    const __m256 xy =
        _mm256_add_ps(_mm256_mul_ps(c0, _mm256_permute_ps(p, 0x00)), _mm256_mul_ps(c1, _mm256_permute_ps(p, 0x55)));
    const __m256 q = _mm256_add_ps(_mm256_add_ps(xy, _mm256_mul_ps(c2, _mm256_permute_ps(p, 0xAA))), c3);
    const __m256 weight = _mm256_permute_ps(side_by_side(records[v].weight, records[v + 1].weight), 0x00);
    const __m256 sum = _mm256_mul_ps(q, weight);
    _mm_storeu_ps(out, _mm256_castps256_ps128(sum));
    _mm_storeu_ps(out + 3, _mm256_extractf128_ps(sum, 1));
  }
  return v;
}

}  // namespace

// A vertex half a vector. Most follow one segment, and neighbours the same one: those go in pairs, its matrix in
// registers.
void skin_avx2(const float* vertices, const SkinRecord* skin_records, int vertex_count, const SkinMatrix* matrices,
               float* out) {
  const Record* records = reinterpret_cast<const Record*>(skin_records);
  int v = 0;
  while (v + 1 < vertex_count) {
    const std::uint8_t segment = records[v].segment[0];
    const int done =
        only_follow(records + v, segment)
            ? skin_followers(vertices + 3 * v, records + v, vertex_count - v, matrices, segment, out + 3 * v)
            : 0;
    v += done;
    if (done != 0) continue;
    _mm_storeu_ps(out + 3 * v, skinned(vertices + 3 * v, records + v, matrices));
    ++v;
  }
  if (v == vertex_count) return;
  const __m128 last = skinned(vertices + 3 * v, records + v, matrices);
  _mm_storel_pi(reinterpret_cast<__m64*>(out + 3 * v), last);
  _mm_store_ss(out + 3 * v + 2, _mm_movehl_ps(last, last));
}

}  // namespace im2fit
