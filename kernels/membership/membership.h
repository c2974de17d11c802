// SPDX-License-Identifier: Apache-2.0
// From chosen cells to pixels: which pixels of a cell lie on the person's surface, judged by the cells around it.
#pragma once

#include <cstdint>

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit {

inline constexpr std::uint16_t kNoSurface = 65535;

// Depths of cells, one plane of those that are the person's and one of the others, kNoSurface elsewhere. A plane has
// one more cell on every side, of kNoSurface; `person` and `other` point at cell (0, 0).
struct MembershipCells {
  const std::uint16_t* person;
  const std::uint16_t* other;
  int stride;         // cells from row to row
  int width, height;  // cells
  int step;           // px; the last column and row of cells cover the rest of the picture
};

// For each of the `count` cells (row << 16 | column): writes 255 to the mask where a pixel with data (1..10000 mm)
// belongs, 0 elsewhere. A pixel belongs when the nearest in depth of the person's cells among the nine around it is
// within 40 mm + 1.5 disparity steps and no other cell is nearer; in a cell of the person without others around it
// also when within 40 mm of that cell. No allocation, thread-safe. Distances are integers and the limit one float
// (2.85e-6 z z) * 1.5 + 40 in this order: all tiers agree bit for bit.
using MembershipFunction = void(DepthView depth, const MembershipCells& cells, const std::uint32_t* list, int count,
                                MaskImage mask);
MembershipFunction membership_portable, membership_neon, membership_avx2;
MembershipFunction membership;  // the fastest here

using MembershipKernel = KernelVariant<MembershipFunction>;
inline constexpr MembershipKernel kMembershipKernels[] = {IM2FIT_PORTABLE(membership) IM2FIT_NEON(membership)
                                                              IM2FIT_AVX2(membership)};

}  // namespace im2fit
