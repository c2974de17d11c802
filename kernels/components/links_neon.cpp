// SPDX-License-Identifier: Apache-2.0
#include <arm_neon.h>

#include "kernels/components/links_edges.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

struct Here {
  uint16x8_t surface, limit;
};

// `bit` where cell and neighbour are one surface. Closed cells have depth and limit 0: an open one is never that
// near.
uint16x8_t join(const Here& here, const LinkCells& cells, std::ptrdiff_t there, int bit) {
  const uint16x8_t limit = vminq_u16(here.limit, vld1q_u16(cells.limit + there));
  const uint16x8_t away = vabdq_u16(here.surface, vld1q_u16(cells.surface + there));
  return vandq_u16(vcleq_u16(away, limit), vdupq_n_u16(static_cast<std::uint16_t>(bit)));
}
uint16x8_t hole(const LinkCells& cells, std::ptrdiff_t there) {
  return vceqq_u16(vld1q_u16(cells.depth + there), vdupq_n_u16(0));
}

void eight(const LinkCells& cells, std::ptrdiff_t here, std::uint8_t* links) {
  const std::ptrdiff_t width = cells.width;
  const Here own = {vld1q_u16(cells.surface + here), vld1q_u16(cells.limit + here)};
  const uint16x8_t open = vtstq_u16(own.surface, own.surface);
  uint16x8_t bits = join(own, cells, here + 1, kLinkRight);
  bits = vorrq_u16(bits, vandq_u16(join(own, cells, here + 2, kLinkRightOverHole), hole(cells, here + 1)));
  bits = vorrq_u16(bits, join(own, cells, here + width, kLinkDown));
  bits = vorrq_u16(bits, vandq_u16(join(own, cells, here + 2 * width, kLinkDownOverHole), hole(cells, here + width)));
  bits = vorrq_u16(bits, join(own, cells, here + width - 1, kLinkDownLeft));
  bits = vorrq_u16(bits, join(own, cells, here + width + 1, kLinkDownRight));
  vst1_u8(links + here, vmovn_u16(vandq_u16(bits, open)));
}

}  // namespace

void links_neon(const LinkCells& cells, std::uint8_t* links) {
  for (int r = 0; r < cells.height; ++r) {
    int c = 0;
    if (r + 2 < cells.height && cells.width > kLanes + 2) {
      link_cells(cells, r, 0, 1, links);
      for (c = 1; c + kLanes + 2 <= cells.width; c += kLanes)
        eight(cells, static_cast<std::ptrdiff_t>(r) * cells.width + c, links);
    }
    link_cells(cells, r, c, cells.width, links);
  }
}

}  // namespace im2fit
