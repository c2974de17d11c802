// SPDX-License-Identifier: Apache-2.0
// A lane is a row of a cell, so that its pixels are added from left to right as the contract says: two cells of 4 x 4
// pixels at a time, or whichever rows of cells of 2 x 2 come next. A row's ten terms then go into three registers of
// doubles.
#include <immintrin.h>

#include <cstring>

#include "kernels/floor_sums/floor_sums.h"

namespace im2fit {
namespace {

// A value of the first cell in the lower four lanes, of the second in the upper.
__m256 pair(float a, float b) {
  return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_set1_ps(a)), _mm_set1_ps(b), 1);
}
__m256 pair_of_4(const float* a, const float* b) {
  return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(a)), _mm_loadu_ps(b), 1);
}

struct Columns {
  __m256 z[4];
};

// Depths of both cells by column: lane i of z[j] is row i.
Columns columns_of(DepthView depth, const FloorCell& a, const FloorCell& b) {
  const auto row = [&](int i) {
    const auto at = [&](const FloorCell& cell) {
      return reinterpret_cast<const __m128i*>(depth.pixels + std::ptrdiff_t{cell.v + i} * depth.stride + cell.u);
    };
    return _mm256_cvtepi32_ps(
        _mm256_cvtepu16_epi32(_mm_unpacklo_epi64(_mm_loadl_epi64(at(a)), _mm_loadl_epi64(at(b)))));
  };
  const __m256 r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
  const __m256 low01 = _mm256_unpacklo_ps(r0, r1), high01 = _mm256_unpackhi_ps(r0, r1);
  const __m256 low23 = _mm256_unpacklo_ps(r2, r3), high23 = _mm256_unpackhi_ps(r2, r3);
  return {{_mm256_shuffle_ps(low01, low23, 0x44), _mm256_shuffle_ps(low01, low23, 0xEE),
           _mm256_shuffle_ps(high01, high23, 0x44), _mm256_shuffle_ps(high01, high23, 0xEE)}};
}

struct Rows {
  __m256 n, x, xx, t, tx;
};

// Adds a pixel of each row; `counts`: of the rows that have one here.
void add_pixels(const FloorGate& gate, __m256 z, __m256 ray, __m256 row_up, __m256 counts, Rows& rows) {
  const __m256 slope = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(gate.up_x), ray), row_up);
  const __m256 height = _mm256_add_ps(_mm256_mul_ps(slope, z), _mm256_set1_ps(gate.camera_height_mm));
  const __m256 away = _mm256_andnot_ps(_mm256_set1_ps(-0.0F), height);
  const __m256 limit = _mm256_add_ps(_mm256_set1_ps(gate.flat_mm), _mm256_mul_ps(_mm256_set1_ps(gate.noise), z));
  const __m256 seen = _mm256_and_ps(_mm256_cmp_ps(z, _mm256_setzero_ps(), _CMP_GT_OQ),
                                    _mm256_cmp_ps(z, _mm256_set1_ps(10000.0F), _CMP_LE_OQ));
  const __m256 take = _mm256_and_ps(counts, _mm256_andnot_ps(_mm256_cmp_ps(away, limit, _CMP_GT_OQ), seen));
  const __m256 one = _mm256_set1_ps(1.0F);
  const __m256 inverse = _mm256_div_ps(one, z);
  rows.n = _mm256_add_ps(rows.n, _mm256_and_ps(take, one));
  rows.x = _mm256_add_ps(rows.x, _mm256_and_ps(take, ray));
  rows.xx = _mm256_add_ps(rows.xx, _mm256_and_ps(take, _mm256_mul_ps(ray, ray)));
  rows.t = _mm256_add_ps(rows.t, _mm256_and_ps(take, inverse));
  rows.tx = _mm256_add_ps(rows.tx, _mm256_and_ps(take, _mm256_mul_ps(inverse, ray)));
}

Rows no_rows() {
  const __m256 zero = _mm256_setzero_ps();
  return {zero, zero, zero, zero, zero};
}

void sum_rows(DepthView depth, const FloorGate& gate, const FloorCell& a, const FloorCell& b, Rows& rows) {
  const Columns columns = columns_of(depth, a, b);
  const __m256 row_up = pair_of_4(gate.row_up + a.v, gate.row_up + b.v);
  const __m256 all = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
  rows = no_rows();
  for (int j = 0; j < 4; j += a.stride)
    add_pixels(gate, columns.z[j], pair(gate.ray_x[a.u + j], gate.ray_x[b.u + j]), row_up, all, rows);
}

struct Sums {
  __m256d xx_xy_x_yy = _mm256_setzero_pd(), y_1_tx_ty = _mm256_setzero_pd();
  __m128d t_n = _mm_setzero_pd();
};

// Four registers of four rows each become four rows of four terms.
void transpose(__m256d& a, __m256d& b, __m256d& c, __m256d& d) {
  const __m256d ab_even = _mm256_unpacklo_pd(a, b), ab_odd = _mm256_unpackhi_pd(a, b);
  const __m256d cd_even = _mm256_unpacklo_pd(c, d), cd_odd = _mm256_unpackhi_pd(c, d);
  a = _mm256_permute2f128_pd(ab_even, cd_even, 0x20);
  b = _mm256_permute2f128_pd(ab_odd, cd_odd, 0x20);
  c = _mm256_permute2f128_pd(ab_even, cd_even, 0x31);
  d = _mm256_permute2f128_pd(ab_odd, cd_odd, 0x31);
}

template <int kHalf>
__m256d half(__m256 v) {
  return _mm256_cvtps_pd(_mm256_extractf128_ps(v, kHalf));
}

// Four rows, from half of each register, of these weights and rays; bit i of `kept`: row i.
template <int kHalf>
void add_rows(Sums& sums, const Rows& rows, __m256d d, __m256d y, unsigned kept) {
  const __m256d minus = _mm256_set1_pd(-0.0);
  const __m256d x = _mm256_mul_pd(d, half<kHalf>(rows.x)), n = _mm256_mul_pd(d, half<kHalf>(rows.n));
  const __m256d t = _mm256_xor_pd(_mm256_mul_pd(d, half<kHalf>(rows.t)), minus);
  __m256d a0 = _mm256_mul_pd(d, half<kHalf>(rows.xx)), a1 = _mm256_mul_pd(x, y), a2 = x;
  __m256d b0 = _mm256_mul_pd(n, y), b1 = n, b2 = _mm256_xor_pd(_mm256_mul_pd(d, half<kHalf>(rows.tx)), minus);
  __m256d a3 = _mm256_mul_pd(b0, y), b3 = _mm256_mul_pd(t, y);
  transpose(a0, a1, a2, a3);
  transpose(b0, b1, b2, b3);
  const __m256d t_n_even = _mm256_unpacklo_pd(t, n), t_n_odd = _mm256_unpackhi_pd(t, n);
  const auto add = [&](__m256d a, __m256d b, __m128d c) {
    sums.xx_xy_x_yy = _mm256_add_pd(sums.xx_xy_x_yy, a);
    sums.y_1_tx_ty = _mm256_add_pd(sums.y_1_tx_ty, b);
    sums.t_n = _mm_add_pd(sums.t_n, c);
  };
  if ((kept & 1U) != 0) add(a0, b0, _mm256_castpd256_pd128(t_n_even));
  if ((kept & 2U) != 0) add(a1, b1, _mm256_castpd256_pd128(t_n_odd));
  if ((kept & 4U) != 0) add(a2, b2, _mm256_extractf128_pd(t_n_even, 1));
  if ((kept & 8U) != 0) add(a3, b3, _mm256_extractf128_pd(t_n_odd, 1));
}

// The four rows of a cell; of stride 2 only the first and third.
template <int kHalf>
void add_cell(Sums& sums, const Rows& rows, const FloorGate& gate, const FloorCell& cell) {
  add_rows<kHalf>(sums, rows, _mm256_set1_pd(static_cast<double>(cell.weight)),
                  _mm256_cvtps_pd(_mm_loadu_ps(gate.ray_y + cell.v)), cell.stride == 1 ? 0xFU : 0x5U);
}

void sums_of_4(DepthView depth, const FloorGate& gate, const FloorCell* cells, int count, Sums& sums) {
  Rows rows;
  for (int i = 0; i < count;) {
    const bool two = i + 1 < count && cells[i].stride == cells[i + 1].stride;
    const FloorCell &a = cells[i], &b = cells[two ? i + 1 : i];
    sum_rows(depth, gate, a, b, rows);
    add_cell<0>(sums, rows, gate, a);
    if (two) add_cell<1>(sums, rows, gate, b);
    i += two ? 2 : 1;
  }
}

// Rows of two pixels.
struct ShortRows {
  alignas(32) std::uint32_t pixels[8] = {};
  alignas(32) std::int32_t both[8] = {};  // -1: the second one counts, too
  alignas(32) float ray[8] = {}, next_ray[8] = {}, row_up[8] = {}, ray_y[8] = {}, weight[8] = {};
  unsigned count = 0;

  void push(DepthView depth, const FloorGate& gate, const FloorCell& cell, int v) {
    std::memcpy(&pixels[count], depth.pixels + std::ptrdiff_t{v} * depth.stride + cell.u, sizeof pixels[count]);
    both[count] = cell.stride == 1 ? -1 : 0;
    ray[count] = gate.ray_x[cell.u];
    next_ray[count] = gate.ray_x[cell.u + 1];
    row_up[count] = gate.row_up[v];
    ray_y[count] = gate.ray_y[v];
    weight[count] = cell.weight;
    ++count;
  }
  void add_to(Sums& sums, const FloorGate& gate) {
    const __m256i two = _mm256_load_si256(reinterpret_cast<const __m256i*>(pixels));
    const __m256 first = _mm256_cvtepi32_ps(_mm256_and_si256(two, _mm256_set1_epi32(0xFFFF)));
    const __m256 second = _mm256_cvtepi32_ps(_mm256_srli_epi32(two, 16));
    const __m256 up = _mm256_load_ps(row_up);
    Rows rows = no_rows();
    add_pixels(gate, first, _mm256_load_ps(ray), up, _mm256_castsi256_ps(_mm256_set1_epi32(-1)), rows);
    add_pixels(gate, second, _mm256_load_ps(next_ray), up,
               _mm256_castsi256_ps(_mm256_load_si256(reinterpret_cast<const __m256i*>(both))), rows);
    const unsigned kept = (1U << count) - 1;
    add_rows<0>(sums, rows, _mm256_cvtps_pd(_mm_load_ps(weight)), _mm256_cvtps_pd(_mm_load_ps(ray_y)), kept);
    if (count > 4)
      add_rows<1>(sums, rows, _mm256_cvtps_pd(_mm_load_ps(weight + 4)), _mm256_cvtps_pd(_mm_load_ps(ray_y + 4)),
                  kept >> 4);
    count = 0;
  }
};

void sums_of_2(DepthView depth, const FloorGate& gate, const FloorCell* cells, int count, Sums& sums) {
  ShortRows rows;
  for (int i = 0; i < count; ++i)
    for (int v = cells[i].v; v < cells[i].v + 2; v += cells[i].stride) {
      rows.push(depth, gate, cells[i], v);
      if (rows.count == 8) rows.add_to(sums, gate);
    }
  if (rows.count > 0) rows.add_to(sums, gate);
}

}  // namespace

void floor_sums_avx2(DepthView depth, int step, const FloorGate& gate, const FloorCell* cells, int count,
                     PlaneSums& out) {
  if (step != 4 && step != 2) return floor_sums_portable(depth, step, gate, cells, count, out);
  Sums sums;
  if (step == 4)
    sums_of_4(depth, gate, cells, count, sums);
  else
    sums_of_2(depth, gate, cells, count, sums);
  double first[4], second[4], third[2];
  _mm256_storeu_pd(first, sums.xx_xy_x_yy);
  _mm256_storeu_pd(second, sums.y_1_tx_ty);
  _mm_storeu_pd(third, sums.t_n);
  out = {{first[0], first[1], first[2], first[3], second[0], second[1]}, {second[2], second[3], third[0]}, third[1]};
}

}  // namespace im2fit
