// SPDX-License-Identifier: Apache-2.0
#include "kernels/height/height.h"
#include "kernels/rayform/rayform_avx2.h"

namespace im2fit {
namespace {

// Bins of neighbouring pixels are mostly the same one: even and odd pixels add to tables of their own, so that a sum
// need not wait for the one before. The last bin of each takes what does not count.
struct Tables {
  std::uint64_t even[kHeightBins + 1], odd[kHeightBins + 1];
};

struct Constants {
  __m256i up_offset, side_offset, side_max, bin_offset;
};

inline __m256i scan8(const HeightScan& s, const Constants& c, const std::uint16_t* depth, const std::uint8_t* mask,
                     int u, __m256i up_row, __m256i side_row, __m256i lowest, Tables& tables) {
  const __m256i d = seen_depth8(depth, mask);
  const FormDepth8 z = form_depth8(d);
  const __m256i side = _mm256_add_epi32(form_product8(form_slope8(s.side_columns + u, side_row), z), c.side_offset);
  const __m256i counts = _mm256_and_si256(_mm256_cmpgt_epi32(d, _mm256_setzero_si256()),
                                          _mm256_cmpgt_epi32(c.side_max, _mm256_abs_epi32(side)));
  if (_mm256_testz_si256(counts, counts) != 0) return lowest;
  const __m256i height = _mm256_add_epi32(form_product8(form_slope8(s.up_columns + u, up_row), z), c.up_offset);
  const __m256i bins = _mm256_srai_epi32(_mm256_sub_epi32(height, c.bin_offset), kHeightBinShift);
  const __m256i trash = _mm256_set1_epi32(kHeightBins);
  const __m256i inside = _mm256_and_si256(counts, _mm256_cmpgt_epi32(bins, _mm256_set1_epi32(-1)));
  alignas(32) std::uint32_t bin[8];
  alignas(32) std::uint32_t square[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(bin),
                     _mm256_min_epi32(_mm256_blendv_epi8(trash, bins, inside), trash));
  _mm256_store_si256(reinterpret_cast<__m256i*>(square), _mm256_mullo_epi32(d, d));
  for (int i = 0; i < 8; i += 2) {
    tables.even[bin[i]] += square[i];
    tables.odd[bin[i + 1]] += square[i + 1];
  }
  return _mm256_min_epi32(lowest, _mm256_blendv_epi8(_mm256_set1_epi32(kHeightNone), height, counts));
}

}  // namespace

std::int32_t height_avx2(const HeightScan& s, std::uint64_t* squares) {
  Tables tables;
  for (int i = 0; i <= kHeightBins; ++i) tables.even[i] = tables.odd[i] = 0;
  const Constants c = {_mm256_set1_epi32(s.up_offset), _mm256_set1_epi32(s.side_offset),
                       _mm256_set1_epi32(s.side_max),
                       _mm256_set1_epi32(kHeightMinMm * (1 << CoordinateMm::kFractionBits))};
  __m256i lowest = _mm256_set1_epi32(kHeightNone);
  const int width = s.depth_q4.width;
  // A row's last pixels, fewer than eight, are copied into room for eight.
  const int whole = width & ~7;
  for (std::ptrdiff_t v = 0; v < s.depth_q4.height; ++v) {
    const std::uint16_t* depth = s.depth_q4.pixels + v * s.depth_q4.stride;
    const std::uint8_t* mask = s.mask.pixels + v * s.mask.stride;
    const __m256i up_row = _mm256_set1_epi32(s.up_rows[v]), side_row = _mm256_set1_epi32(s.side_rows[v]);
    for (int u = 0; u < whole; u += 8) {
      if (masked8(mask + u)) lowest = scan8(s, c, depth + u, mask + u, u, up_row, side_row, lowest, tables);
    }
    if (whole < width) {
      std::uint16_t depth_tail[8] = {};
      std::uint8_t mask_tail[8] = {};
      std::int32_t up_tail[8] = {}, side_tail[8] = {};
      for (int i = 0; i < width - whole; ++i) {
        depth_tail[i] = depth[whole + i];
        mask_tail[i] = mask[whole + i];
        up_tail[i] = s.up_columns[whole + i];
        side_tail[i] = s.side_columns[whole + i];
      }
      HeightScan tail = s;
      tail.up_columns = up_tail;
      tail.side_columns = side_tail;
      if (masked8(mask_tail)) lowest = scan8(tail, c, depth_tail, mask_tail, 0, up_row, side_row, lowest, tables);
    }
  }
  for (int i = 0; i < kHeightBins; ++i) squares[i] = tables.even[i] + tables.odd[i];
  alignas(32) std::int32_t lanes[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(lanes), lowest);
  std::int32_t result = lanes[0];
  for (int i = 1; i < 8; ++i) result = lanes[i] < result ? lanes[i] : result;
  return result;
}

}  // namespace im2fit
