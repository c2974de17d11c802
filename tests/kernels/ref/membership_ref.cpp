// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

double nearest(const std::vector<double>& depths, double z) {
  double best = 1e9;
  for (const double d : depths) best = std::min(best, std::fabs(z - d));
  return best;
}

}  // namespace

void membership_ref(DepthView depth, const MembershipCells& cells, const std::uint32_t* list, int count,
                    MaskImage mask) {
  for (int i = 0; i < count; ++i) {
    const int c = static_cast<int>(list[i] & 0xFFFF), r = static_cast<int>(list[i] >> 16);
    std::vector<double> person, other;
    for (int rr = r - 1; rr <= r + 1; ++rr) {
      for (int cc = c - 1; cc <= c + 1; ++cc) {
        const std::uint16_t p = cells.person[rr * cells.stride + cc], o = cells.other[rr * cells.stride + cc];
        if (p != kNoSurface) person.push_back(p);
        if (o != kNoSurface) other.push_back(o);
      }
    }
    const std::uint16_t own = cells.person[r * cells.stride + c];
    const int v_end = r + 1 == cells.height ? mask.height : (r + 1) * cells.step;
    const int u_end = c + 1 == cells.width ? mask.width : (c + 1) * cells.step;
    for (int v = r * cells.step; v < v_end; ++v) {
      for (int u = c * cells.step; u < u_end; ++u) {
        const double z = depth.at(u, v);
        const double limit = 40 + 1.5 * 2.85e-6 * z * z;
        const double away = nearest(person, z);
        const bool inside = other.empty() && own != kNoSurface && std::fabs(z - own) < 40;
        const bool belongs = away <= limit && away <= nearest(other, z);
        mask.at(u, v) = z >= 1 && z <= 10000 && (inside || belongs) ? 255 : 0;
      }
    }
  }
}

}  // namespace im2fit
