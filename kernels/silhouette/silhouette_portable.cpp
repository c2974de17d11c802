// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>

#include "kernels/silhouette/silhouette.h"

namespace im2fit {
namespace {

constexpr int kBlock = 32;  // pixels whose u z sum stays below 2^31 when u counts from the block's start

bool all_zero(const std::uint8_t* m, int count) {
  std::uint64_t any = 0;
  int i = 0;
  for (; i + 8 <= count; i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, m + i, sizeof word);
    any |= word;
  }
  for (; i < count; ++i) any |= m[i];
  return any == 0;
}

}  // namespace

void silhouette_portable(DepthView depth, MaskView mask, Silhouette& out) {
  out = {};
  int u_min = mask.width, u_max = -1;
  for (int v = 0; v < mask.height; ++v) {
    const std::uint8_t* m = mask.row(v);
    const std::uint16_t* z = depth.row(v);
    std::uint64_t row_z = 0, row_uz = 0;
    int row_count = 0;
    for (int u0 = 0; u0 < mask.width; u0 += kBlock) {
      const int count = std::min(kBlock, mask.width - u0);
      if (all_zero(m + u0, count)) continue;
      std::uint32_t sum = 0, weighted = 0, pixels = 0;
      for (int i = 0; i < count; ++i) {
        const std::uint32_t seen = m[u0 + i] != 0 ? z[u0 + i] : 0U;
        sum += seen;
        weighted += static_cast<std::uint32_t>(i) * seen;
        pixels += m[u0 + i] & 1U;
      }
      int first = u0, last = u0 + count - 1;
      while (m[first] == 0) ++first;
      while (m[last] == 0) --last;
      u_min = std::min(u_min, first);
      u_max = std::max(u_max, last);
      row_z += sum;
      row_uz += static_cast<std::uint64_t>(u0) * sum + weighted;
      row_count += static_cast<int>(pixels);
    }
    if (row_count == 0) continue;
    if (out.count == 0) out.v_min = v;
    out.v_max = v;
    out.count += row_count;
    out.sum_z += row_z;
    out.sum_uz += row_uz;
    out.sum_vz += row_z * static_cast<std::uint64_t>(v);
  }
  if (out.count == 0) return;
  out.u_min = u_min;
  out.u_max = u_max;
}

void silhouette(DepthView depth, MaskView mask, Silhouette& out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kSilhouetteKernels);
  best(depth, mask, out);
}

}  // namespace im2fit
