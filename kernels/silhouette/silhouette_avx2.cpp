// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/silhouette/silhouette_rows.h"

namespace im2fit {
namespace {

constexpr int kLanes = 16;
constexpr int kFlush = 8;  // a lane takes 2 x 32767 x 2047 a step: eight stay below 2^31

std::uint64_t sum_of(__m256i v) {  // of eight 32-bit lanes
  const __m256i zero = _mm256_setzero_si256();
  const __m256i wide = _mm256_add_epi64(_mm256_unpacklo_epi32(v, zero), _mm256_unpackhi_epi32(v, zero));
  const __m128i two = _mm_add_epi64(_mm256_castsi256_si128(wide), _mm256_extracti128_si256(wide, 1));
  return static_cast<std::uint64_t>(_mm_cvtsi128_si64(two)) + static_cast<std::uint64_t>(_mm_extract_epi64(two, 1));
}

using Row = SilhouetteRow;

Row measure_row(const std::uint16_t* z, const std::uint8_t* m, int width) {
  Row row;
  __m256i z_sum = _mm256_setzero_si256(), uz_sum = z_sum;
  int steps = 0, u = 0;
  const __m256i count_up = _mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  for (; u + kLanes <= width; u += kLanes) {
    const __m128i mask = _mm_loadu_si128(reinterpret_cast<const __m128i*>(m + u));
    const auto bits = static_cast<unsigned>(_mm_movemask_epi8(mask));
    if (bits == 0) continue;
    const __m256i seen =
        _mm256_and_si256(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(z + u)), _mm256_cvtepi8_epi16(mask));
    const __m256i columns = _mm256_add_epi16(count_up, _mm256_set1_epi16(static_cast<short>(u)));
    z_sum = _mm256_add_epi32(z_sum, _mm256_madd_epi16(seen, _mm256_set1_epi16(1)));
    uz_sum = _mm256_add_epi32(uz_sum, _mm256_madd_epi16(seen, columns));
    if (row.count == 0) row.first = u + __builtin_ctz(bits);
    row.last = u + 31 - __builtin_clz(bits);
    row.count += __builtin_popcount(bits);
    if (++steps == kFlush) {
      row.uz += sum_of(uz_sum);
      uz_sum = _mm256_setzero_si256();
      steps = 0;
    }
  }
  row.z = sum_of(z_sum);
  row.uz += sum_of(uz_sum);
  for (; u < width; ++u) {
    if (m[u] == 0) continue;
    if (row.count++ == 0) row.first = u;
    row.last = u;
    row.z += z[u];
    row.uz += static_cast<std::uint64_t>(u) * z[u];
  }
  return row;
}

}  // namespace

void silhouette_avx2(DepthView depth, MaskView mask, Silhouette& out) {
  out = silhouette_of_rows(depth, mask, measure_row);
}

}  // namespace im2fit
