// SPDX-License-Identifier: Apache-2.0
// The loops of rows.h, for the files that compile them once for each instruction set.
#pragma once

#include <cstring>

#include "body/fit/rows.h"

namespace im2fit::body {
namespace {

// What one instruction set's registers hold: wider vectors would go through memory.
using Eight = float __attribute__((vector_size(8 * sizeof(float))));

template <class Vector>
inline Vector vector_at(const float* p) {
  Vector out;
  std::memcpy(&out, p, sizeof out);
  return out;
}

// A row of the matrix a pass, from the vector its diagonal lies in: eight weighted slopes stay in registers, eight
// come from memory.
template <class Vector>
void sum_rows_loop(const RowGroup& group, float* sums, double* __restrict right) {
  const std::size_t stride = group.stride, width = group.width;
  const float* w = group.weight;
  const float *j0 = group.rows, *j1 = j0 + stride, *j2 = j1 + stride, *j3 = j2 + stride, *j4 = j3 + stride,
              *j5 = j4 + stride, *j6 = j5 + stride, *j7 = j6 + stride;
  for (std::size_t i = 0; i < width; ++i) {
    const float w0 = w[0] * j0[i], w1 = w[1] * j1[i], w2 = w[2] * j2[i], w3 = w[3] * j3[i], w4 = w[4] * j4[i],
                w5 = w[5] * j5[i], w6 = w[6] * j6[i], w7 = w[7] * j7[i];
    float* sum = sums + i * stride;
    constexpr std::size_t kLanes = sizeof(Vector) / sizeof(float);
    static_assert(kRowLanes % kLanes == 0);
    for (std::size_t c = i - i % kLanes; c < width; c += kLanes) {
      const auto j = [c](const float* row) { return vector_at<Vector>(row + c); };
      const Vector more = ((w0 * j(j0) + w1 * j(j1)) + (w2 * j(j2) + w3 * j(j3))) +
                          ((w4 * j(j4) + w5 * j(j5)) + (w6 * j(j6) + w7 * j(j7)));
      const Vector all = j(sum) + more;
      std::memcpy(sum + c, &all, sizeof all);
    }
  }

  double by[kRowGroup];
  for (std::size_t k = 0; k < kRowGroup; ++k)
    by[k] = static_cast<double>(w[k]) * static_cast<double>(group.residual[k]);
  for (std::size_t c = 0; c < width; ++c) {
    double sum = right[c];
    sum += by[0] * static_cast<double>(j0[c]);
    sum += by[1] * static_cast<double>(j1[c]);
    sum += by[2] * static_cast<double>(j2[c]);
    sum += by[3] * static_cast<double>(j3[c]);
    sum += by[4] * static_cast<double>(j4[c]);
    sum += by[5] * static_cast<double>(j5[c]);
    sum += by[6] * static_cast<double>(j6[c]);
    sum += by[7] * static_cast<double>(j7[c]);
    right[c] = sum;
  }
}

void add_slopes_loop(const SlopeParts& parts, float* __restrict out) {
  const std::size_t count = parts.count;
  for (std::size_t p = 0; p < parts.parts; ++p) {
    const float* x = parts.rows[p];
    const float *y = x + count, *z = y + count;
    const float nx = parts.along[p][0], ny = parts.along[p][1], nz = parts.along[p][2];
    if (p == 0)
      for (std::size_t k = 0; k < count; ++k) out[k] = nx * x[k] + ny * y[k] + nz * z[k];
    else
      for (std::size_t k = 0; k < count; ++k) out[k] += nx * x[k] + ny * y[k] + nz * z[k];
  }
}

// Four values a pass: their sums do not wait for each other.
void add_shapes_loop(const ShapeRows& rows, float* __restrict out) {
  const std::size_t count = rows.shape_count, in_fours = count - count % 4;
  const float* c = rows.coefficients;
  const auto four_of = [](const float* p) { return vector_at<Four>(p); };
  const auto rest = [&](Four& sum, const float* row) {
    for (std::size_t k = in_fours; k < count; ++k) sum[0] += row[k] * c[k];
  };
  std::size_t i = 0;
  for (; i + 4 <= rows.value_count; i += 4) {
    const float *a = rows.basis + i * count, *b = a + count, *d = b + count, *e = d + count;
    Four in_a = {rows.mean[i]}, in_b = {rows.mean[i + 1]}, in_d = {rows.mean[i + 2]}, in_e = {rows.mean[i + 3]};
    for (std::size_t k = 0; k < in_fours; k += 4) {
      const Four amount = four_of(c + k);
      in_a += four_of(a + k) * amount;
      in_b += four_of(b + k) * amount;
      in_d += four_of(d + k) * amount;
      in_e += four_of(e + k) * amount;
    }
    rest(in_a, a);
    rest(in_b, b);
    rest(in_d, d);
    rest(in_e, e);
    const Four ab = __builtin_shufflevector(in_a, in_b, 0, 4, 1, 5),
               ab_more = __builtin_shufflevector(in_a, in_b, 2, 6, 3, 7);
    const Four de = __builtin_shufflevector(in_d, in_e, 0, 4, 1, 5),
               de_more = __builtin_shufflevector(in_d, in_e, 2, 6, 3, 7);
    const Four first = __builtin_shufflevector(ab, de, 0, 1, 4, 5),
               second = __builtin_shufflevector(ab, de, 2, 3, 6, 7);
    const Four third = __builtin_shufflevector(ab_more, de_more, 0, 1, 4, 5),
               fourth = __builtin_shufflevector(ab_more, de_more, 2, 3, 6, 7);
    const Four sum = (first + second) + (third + fourth);
    std::memcpy(out + i, &sum, sizeof sum);
  }
  for (; i < rows.value_count; ++i) {
    const float* row = rows.basis + i * count;
    Four sum = {rows.mean[i]};
    for (std::size_t k = 0; k < in_fours; k += 4) sum += four_of(row + k) * four_of(c + k);
    rest(sum, row);
    out[i] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }
}

using Doubles = double __attribute__((vector_size(4 * sizeof(double))));

// Some vectors of columns stay in registers while the pivots go by.
template <int kVectors>
void take_columns(const PivotRows& rows, std::size_t column) {
  const auto at = [&](std::size_t row, int v) {
    return rows.matrix + row * rows.stride + column + 4 * static_cast<std::size_t>(v);
  };
  Doubles left[kVectors];
  for (int v = 0; v < kVectors; ++v) std::memcpy(&left[v], at(rows.row, v), sizeof left[v]);
  for (std::size_t k = rows.pivot_first; k < rows.pivot_end; ++k) {
    const double factor = rows.matrix[k * rows.stride + rows.row];
    for (int v = 0; v < kVectors; ++v) {
      Doubles pivot;
      std::memcpy(&pivot, at(k, v), sizeof pivot);
      left[v] -= factor * pivot;
    }
  }
  for (int v = 0; v < kVectors; ++v) std::memcpy(at(rows.row, v), &left[v], sizeof left[v]);
}

void take_pivots_loop(const PivotRows& rows) {
  std::size_t c = rows.column_first;
  for (; c + 16 <= rows.column_end; c += 16) take_columns<4>(rows, c);
  for (; c + 4 <= rows.column_end; c += 4) take_columns<1>(rows, c);
  for (; c < rows.column_end; ++c) {
    double left = rows.matrix[rows.row * rows.stride + c];
    for (std::size_t k = rows.pivot_first; k < rows.pivot_end; ++k) {
      const double* pivot = rows.matrix + k * rows.stride;
      left -= pivot[rows.row] * pivot[c];
    }
    rows.matrix[rows.row * rows.stride + c] = left;
  }
}

}  // namespace
}  // namespace im2fit::body
