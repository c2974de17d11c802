// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void contour_ref(ImageView<const std::uint16_t> depth_q4, MaskView mask, ContourRow* rows, std::uint64_t* seen,
                 std::uint64_t* steps) {
  const std::size_t words = contour_words(depth_q4.width);
  std::fill_n(seen, words * static_cast<std::size_t>(depth_q4.height), 0);
  std::fill_n(steps, words * static_cast<std::size_t>(depth_q4.height), 0);
  const auto depth_at = [&](int u, int v) {
    return u >= 0 && mask.at(u, v) != 0 ? static_cast<int>(depth_q4.at(u, v)) : 0;
  };
  for (int v = 0; v < depth_q4.height; ++v) {
    ContourRow row = {depth_q4.width, -1, 0, 0, 0};
    for (int u = 0; u < depth_q4.width; ++u) {
      const int here = depth_at(u, v), before = depth_at(u - 1, v);
      if (here == 0) continue;
      const std::size_t word = static_cast<std::size_t>(v) * words + static_cast<std::size_t>(u) / 64;
      const std::uint64_t bit = std::uint64_t{1} << (u % 64);
      seen[word] |= bit;
      if (before != 0 && std::abs(here - before) >= kContourStepQ4) steps[word] |= bit;
      row.first = std::min(row.first, u);
      row.last = u;
      ++row.count;
      row.depth_sum += static_cast<std::uint32_t>(here);
      row.depth_square_sum += static_cast<std::uint64_t>(here) * static_cast<std::uint64_t>(here);
    }
    rows[v] = row;
  }
}

}  // namespace im2fit
