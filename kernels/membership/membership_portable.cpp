// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>

#include "kernels/membership/membership.h"

namespace im2fit {
namespace {

struct Around {
  std::array<std::uint16_t, 9> person, other;
  int person_count = 0, other_count = 0;
};

Around around_of(const MembershipCells& cells, int c, int r) {
  Around out;
  for (int rr = r - 1; rr <= r + 1; ++rr) {
    const std::ptrdiff_t row = std::ptrdiff_t{rr} * cells.stride;
    for (int cc = c - 1; cc <= c + 1; ++cc) {
      const std::uint16_t p = cells.person[row + cc], o = cells.other[row + cc];
      out.person[static_cast<std::size_t>(out.person_count)] = p;
      out.other[static_cast<std::size_t>(out.other_count)] = o;
      out.person_count += p != kNoSurface ? 1 : 0;
      out.other_count += o != kNoSurface ? 1 : 0;
    }
  }
  return out;
}

bool belongs(const Around& around, int z) {
  int best = kNoSurface;
  for (int i = 0; i < around.person_count; ++i)
    best = std::min(best, std::abs(z - around.person[static_cast<std::size_t>(i)]));
  const float depth = static_cast<float>(z);
  if (static_cast<float>(best) > 40.0F + 1.5F * (2.85e-6F * depth * depth)) return false;
  for (int i = 0; i < around.other_count; ++i)
    if (std::abs(z - around.other[static_cast<std::size_t>(i)]) < best) return false;
  return true;
}

}  // namespace

void membership_portable(DepthView depth, const MembershipCells& cells, const std::uint32_t* list, int count,
                         MaskImage mask) {
  for (int i = 0; i < count; ++i) {
    const int c = static_cast<int>(list[i] & 0xFFFF), r = static_cast<int>(list[i] >> 16);
    const Around around = around_of(cells, c, r);
    const int own = cells.person[std::ptrdiff_t{r} * cells.stride + c];
    const bool interior = around.other_count == 0 && own != kNoSurface;
    const int v_end = r + 1 == cells.height ? mask.height : (r + 1) * cells.step;
    const int u_end = c + 1 == cells.width ? mask.width : (c + 1) * cells.step;
    for (int v = r * cells.step; v < v_end; ++v) {
      const std::uint16_t* z_row = depth.row(v);
      std::uint8_t* out = mask.row(v);
      for (int u = c * cells.step; u < u_end; ++u) {
        const int z = z_row[u];
        const bool seen = z >= 1 && z <= 10000;
        out[u] = seen && ((interior && std::abs(z - own) < 40) || belongs(around, z)) ? 255 : 0;
      }
    }
  }
}

void membership(DepthView depth, const MembershipCells& cells, const std::uint32_t* list, int count, MaskImage mask) {
  IM2FIT_CHOSEN_ONCE best = fastest(kMembershipKernels);
  best(depth, cells, list, count, mask);
}

}  // namespace im2fit
