// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/components/links_edges.h"

namespace im2fit {
namespace {

constexpr int kLanes = 16;

__m256i load(const std::uint16_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}
__m256i is_zero(__m256i a) {
  return _mm256_cmpeq_epi16(a, _mm256_setzero_si256());
}

struct Here {
  __m256i surface, limit;
};

// `bit` where cell and neighbour are one surface. Closed cells have depth and limit 0: an open one is never that
// near.
__m256i join(const Here& here, const LinkCells& cells, std::ptrdiff_t there, int bit) {
  const __m256i other = load(cells.surface + there);
  const __m256i limit = _mm256_min_epu16(here.limit, load(cells.limit + there));
  const __m256i away =
      _mm256_or_si256(_mm256_subs_epu16(here.surface, other), _mm256_subs_epu16(other, here.surface));
  return _mm256_and_si256(is_zero(_mm256_subs_epu16(away, limit)), _mm256_set1_epi16(static_cast<short>(bit)));
}

void sixteen(const LinkCells& cells, std::ptrdiff_t here, std::uint8_t* links) {
  const std::ptrdiff_t width = cells.width;
  const Here own = {load(cells.surface + here), load(cells.limit + here)};
  const __m256i closed = is_zero(own.surface);
  __m256i bits = _mm256_setzero_si256();
  if (_mm256_movemask_epi8(closed) != -1) {
    bits = join(own, cells, here + 1, kLinkRight);
    const __m256i right = join(own, cells, here + 2, kLinkRightOverHole);
    bits = _mm256_or_si256(bits, _mm256_and_si256(right, is_zero(load(cells.depth + here + 1))));
    bits = _mm256_or_si256(bits, join(own, cells, here + width, kLinkDown));
    const __m256i down = join(own, cells, here + 2 * width, kLinkDownOverHole);
    bits = _mm256_or_si256(bits, _mm256_and_si256(down, is_zero(load(cells.depth + here + width))));
    bits = _mm256_or_si256(bits, join(own, cells, here + width - 1, kLinkDownLeft));
    bits = _mm256_or_si256(bits, join(own, cells, here + width + 1, kLinkDownRight));
    bits = _mm256_andnot_si256(closed, bits);
  }
  _mm_storeu_si128(reinterpret_cast<__m128i*>(links + here),
                   _mm_packus_epi16(_mm256_castsi256_si128(bits), _mm256_extracti128_si256(bits, 1)));
}

}  // namespace

void links_avx2(const LinkCells& cells, std::uint8_t* links) {
  for (int r = 0; r < cells.height; ++r) {
    int c = 0;
    if (r + 2 < cells.height && cells.width > kLanes + 2) {
      link_cells(cells, r, 0, 1, links);
      for (c = 1; c + kLanes + 2 <= cells.width; c += kLanes)
        sixteen(cells, static_cast<std::ptrdiff_t>(r) * cells.width + c, links);
    }
    link_cells(cells, r, c, cells.width, links);
  }
  _mm256_zeroupper();  // GCC 12 forgets it at -O2
}

}  // namespace im2fit
