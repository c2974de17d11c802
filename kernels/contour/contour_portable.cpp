// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "kernels/contour/contour.h"

namespace im2fit {
namespace {

// Up to 64 pixels from `depth` and `mask` on; `before` is the depth of the pixel before them, 0 where it is not seen.
struct Word {
  std::uint64_t seen = 0, steps = 0;
};
Word scan_word(const std::uint16_t* depth, const std::uint8_t* mask, int count, int& before, ContourRow& row) {
  Word word;
  for (int i = 0; i < count; ++i) {
    const int here = mask[i] != 0 ? depth[i] : 0;
    const int rise = here > before ? here - before : before - here;
    const bool is_seen = here != 0;
    const bool is_step = is_seen && before != 0 && rise >= kContourStepQ4;
    word.seen |= std::uint64_t{is_seen} << i;
    word.steps |= std::uint64_t{is_step} << i;
    row.depth_sum += static_cast<std::uint32_t>(here);
    row.depth_square_sum += static_cast<std::uint32_t>(here) * static_cast<std::uint32_t>(here);
    before = here;
  }
  return word;
}

bool empty(const std::uint8_t* mask, int count) {
  int i = 0;
  for (; i + 8 <= count; i += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, mask + i, 8);
    if (eight != 0) return false;
  }
  for (; i < count; ++i)
    if (mask[i] != 0) return false;
  return true;
}

}  // namespace

void contour_portable(ImageView<const std::uint16_t> depth_q4, MaskView mask, ContourRow* rows, std::uint64_t* seen,
                      std::uint64_t* steps) {
  const int width = depth_q4.width;
  for (int v = 0; v < depth_q4.height; ++v) {
    const std::uint16_t* depth_row = depth_q4.row(v);
    const std::uint8_t* mask_row = mask.row(v);
    ContourRow row = {width, -1, 0, 0, 0};
    int before = 0;
    for (int u = 0; u < width; u += 64, ++seen, ++steps) {
      const int count = width - u < 64 ? width - u : 64;
      Word word;
      if (empty(mask_row + u, count)) {
        before = 0;
      } else {
        word = scan_word(depth_row + u, mask_row + u, count, before, row);
      }
      *seen = word.seen;
      *steps = word.steps;
      if (word.seen == 0) continue;
      if (row.last < 0) row.first = u + __builtin_ctzll(word.seen);
      row.last = u + 63 - __builtin_clzll(word.seen);
      row.count += static_cast<std::uint32_t>(__builtin_popcountll(word.seen));
    }
    rows[v] = row;
  }
}

void contour(ImageView<const std::uint16_t> depth_q4, MaskView mask, ContourRow* rows, std::uint64_t* seen,
             std::uint64_t* steps) {
  IM2FIT_CHOSEN_ONCE best = fastest(kContourKernels);
  best(depth_q4, mask, rows, seen, steps);
}

}  // namespace im2fit
