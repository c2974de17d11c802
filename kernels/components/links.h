// SPDX-License-Identifier: Apache-2.0
// Which neighbouring cells of a depth picture are one surface.
#pragma once

#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

// Bits of a cell's link byte: the cells after it in reading order it is joined to.
inline constexpr std::uint8_t kLinkRight = 1;
inline constexpr std::uint8_t kLinkRightOverHole = 2;  // the cell after the next, the next has no data
inline constexpr std::uint8_t kLinkDown = 4;
inline constexpr std::uint8_t kLinkDownOverHole = 8;
inline constexpr std::uint8_t kLinkDownLeft = 16;
inline constexpr std::uint8_t kLinkDownRight = 32;

// width * height cells each. Two open cells (surface != 0) are joined when their depths differ by no more than the
// smaller of their limits; over a hole, a cell of depth 0. No allocation, thread-safe. Integers only: all tiers agree
// bit for bit.
struct LinkCells {
  const std::uint16_t* depth;    // 0 = no data
  const std::uint16_t* surface;  // depth of open cells, 0 elsewhere
  const std::uint16_t* limit;    // 0 where surface is 0
  int width, height;
};
using LinksFunction = void(const LinkCells& cells, std::uint8_t* links);
LinksFunction links_portable, links_neon, links_avx2;
LinksFunction links;  // the fastest here

using LinksKernel = KernelVariant<LinksFunction>;
inline constexpr LinksKernel kLinksKernels[] = {IM2FIT_PORTABLE(links) IM2FIT_NEON(links) IM2FIT_AVX2(links)};

}  // namespace im2fit
