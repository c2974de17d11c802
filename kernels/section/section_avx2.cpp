// SPDX-License-Identifier: Apache-2.0
#include "kernels/rayform/rayform_avx2.h"
#include "kernels/section/section.h"

namespace im2fit {
namespace {

// Row `bits`: the numbers of its set bits, then anything.
struct Compaction {
  std::uint8_t lanes[256][8];
};
constexpr Compaction compaction() {
  Compaction c{};
  for (int bits = 0; bits < 256; ++bits) {
    int count = 0;
    for (int lane = 0; lane < 8; ++lane) {
      if ((bits >> lane & 1) != 0) c.lanes[bits][count++] = static_cast<std::uint8_t>(lane);
    }
  }
  return c;
}
constexpr Compaction kCompaction = compaction();

// Eight columns' tables and the row's values.
struct Columns {
  const std::int32_t *along, *x, *y;
};
struct RowValues {
  __m256i along, x, y;
};

struct Lists {
  SectionPoint* points;
  int capacity;
  int* counts;
};

inline __m256i within(__m256i a, std::int32_t limit) {
  return _mm256_cmpgt_epi32(_mm256_set1_epi32(limit + 1), _mm256_abs_epi32(a));
}

inline __m256i plane_coordinate(__m256i product, std::int32_t centre) {
  return _mm256_srai_epi32(_mm256_sub_epi32(product, _mm256_set1_epi32(centre - 64)), 7);
}

inline void append(__m256i x, __m256i y, unsigned bits, int cut, const Lists& lists) {
  const __m256i pairs = _mm256_blend_epi16(x, _mm256_slli_epi32(y, 16), 0xAA);
  const __m256i lanes =
      _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kCompaction.lanes[bits])));
  const int count = lists.counts[cut];
  SectionPoint* to = lists.points + static_cast<std::ptrdiff_t>(cut) * (lists.capacity + kSectionSlack) + count;
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32(pairs, lanes));
  const int grown = count + __builtin_popcount(bits);
  lists.counts[cut] = grown < lists.capacity ? grown : lists.capacity;
}

inline void scan8(const SectionScan& s, const std::uint16_t* depth, const std::uint8_t* mask, const Columns& columns,
                  const RowValues& row, const Lists& lists) {
  const __m256i d = seen_depth8(depth, mask);
  const __m256i seen = _mm256_cmpgt_epi32(d, _mm256_setzero_si256());
  const FormDepth8 z = form_depth8(d);
  const __m256i along = form_product8(form_slope8(columns.along, row.along), z);
  __m256i x_product = along, y_product = along;
  bool have_products = false;
  for (int cut = 0; cut < s.cut_count; ++cut) {
    const SectionCut& c = s.cuts[cut];
    const __m256i off_plane = _mm256_sub_epi32(along, _mm256_set1_epi32(c.along));
    const __m256i near = _mm256_and_si256(seen, within(off_plane, kSectionOffMax));
    if (_mm256_testz_si256(near, near) != 0) continue;
    if (!have_products) {
      x_product = form_product8(form_slope8(columns.x, row.x), z);
      y_product = form_product8(form_slope8(columns.y, row.y), z);
      have_products = true;
    }
    const __m256i x = plane_coordinate(x_product, c.x), y = plane_coordinate(y_product, c.y);
    const __m256i inside = _mm256_and_si256(within(x, kSectionCoordinateMax), within(y, kSectionCoordinateMax));
    const __m256i off = _mm256_srai_epi32(_mm256_add_epi32(off_plane, _mm256_set1_epi32(16)), 5);
    const __m256i distance =
        _mm256_slli_epi32(_mm256_add_epi32(_mm256_mullo_epi32(x, x), _mm256_mullo_epi32(y, y)), 4);
    const __m256i off_99 = _mm256_mullo_epi32(_mm256_mullo_epi32(off, off), _mm256_set1_epi32(99));
    const __m256i taken = _mm256_and_si256(_mm256_and_si256(near, inside), _mm256_cmpgt_epi32(distance, off_99));
    const int bits = lane_bits8(taken);
    if (bits != 0) append(x, y, static_cast<unsigned>(bits), cut, lists);
  }
}

// A row's last pixels, fewer than eight, copied into room for eight.
void scan_tail(const SectionScan& s, const std::uint16_t* depth, const std::uint8_t* mask, int begin, int count,
               const RowValues& row, const Lists& lists) {
  std::uint16_t depth_tail[8] = {};
  std::uint8_t mask_tail[8] = {};
  std::int32_t along_tail[8] = {}, x_tail[8] = {}, y_tail[8] = {};
  for (int i = 0; i < count; ++i) {
    depth_tail[i] = depth[begin + i];
    mask_tail[i] = mask[begin + i];
    along_tail[i] = s.along_columns[begin + i];
    x_tail[i] = s.x_columns[begin + i];
    y_tail[i] = s.y_columns[begin + i];
  }
  if (masked8(mask_tail)) scan8(s, depth_tail, mask_tail, {along_tail, x_tail, y_tail}, row, lists);
}

}  // namespace

void section_avx2(const SectionScan& s, SectionPoint* points, int capacity, int* counts) {
  for (int cut = 0; cut < s.cut_count; ++cut) counts[cut] = 0;
  const Lists lists = {points, capacity, counts};
  const int width = s.depth_q4.width, whole = width & ~7;
  for (std::ptrdiff_t v = 0; v < s.depth_q4.height; ++v) {
    const std::uint16_t* depth = s.depth_q4.pixels + v * s.depth_q4.stride;
    const std::uint8_t* mask = s.mask.pixels + v * s.mask.stride;
    const RowValues row = {_mm256_set1_epi32(s.along_rows[v]), _mm256_set1_epi32(s.x_rows[v]),
                           _mm256_set1_epi32(s.y_rows[v])};
    for (int u = 0; u < whole; u += 8) {
      if (masked8(mask + u))
        scan8(s, depth + u, mask + u, {s.along_columns + u, s.x_columns + u, s.y_columns + u}, row, lists);
    }
    if (whole < width) scan_tail(s, depth, mask, whole, width - whole, row, lists);
  }
}

}  // namespace im2fit
