// SPDX-License-Identifier: Apache-2.0
#include <cstddef>

#include "core/vec3.h"
#include "kernels/skin/skin.h"

namespace im2fit {
namespace {

inline Vec3f moved(const SkinMatrix& m, const float* p) {
  const auto& c = m.column;
  return {c[0][0] * p[0] + c[1][0] * p[1] + c[2][0] * p[2] + c[3][0],
          c[0][1] * p[0] + c[1][1] * p[1] + c[2][1] * p[2] + c[3][1],
          c[0][2] * p[0] + c[1][2] * p[1] + c[2][2] * p[2] + c[3][2]};
}

}  // namespace

void skin_portable(const float* vertices, const SkinRecord* records, int vertex_count, const SkinMatrix* matrices,
                   float* out) {
  for (int v = 0; v < vertex_count; ++v, vertices += 3, out += 3) {
    const SkinRecord& r = records[v];
    Vec3f sum = moved(matrices[r.segment[0]], vertices) * r.weight[0];
    for (std::size_t i = 1; i < 4 && r.weight[i] > 0; ++i)
      sum = sum + moved(matrices[r.segment[i]], vertices) * r.weight[i];
    out[0] = sum.x;
    out[1] = sum.y;
    out[2] = sum.z;
  }
}

void skin(const float* vertices, const SkinRecord* records, int vertex_count, const SkinMatrix* matrices,
          float* out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kSkinKernels);
  best(vertices, records, vertex_count, matrices, out);
}

}  // namespace im2fit
