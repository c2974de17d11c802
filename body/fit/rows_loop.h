// SPDX-License-Identifier: Apache-2.0
// The loops of rows.h, for the files that compile them once for each instruction set.
#pragma once

#include "body/fit/rows.h"

namespace im2fit::body {
namespace {

// A row of the matrix a pass: eight weighted slopes stay in registers, eight come from memory.
void sum_rows_loop(const RowGroup& group, float* sums, double* __restrict right) {
  const std::size_t stride = group.stride, width = group.width;
  const float* w = group.weight;
  const float *j0 = group.rows, *j1 = j0 + stride, *j2 = j1 + stride, *j3 = j2 + stride, *j4 = j3 + stride,
              *j5 = j4 + stride, *j6 = j5 + stride, *j7 = j6 + stride;
  for (std::size_t i = 0; i < width; ++i) {
    const float w0 = w[0] * j0[i], w1 = w[1] * j1[i], w2 = w[2] * j2[i], w3 = w[3] * j3[i], w4 = w[4] * j4[i],
                w5 = w[5] * j5[i], w6 = w[6] * j6[i], w7 = w[7] * j7[i];
    float* __restrict sum = sums + i * stride;
    for (std::size_t c = i; c < width; ++c)
      sum[c] += ((w0 * j0[c] + w1 * j1[c]) + (w2 * j2[c] + w3 * j3[c])) +
                ((w4 * j4[c] + w5 * j5[c]) + (w6 * j6[c] + w7 * j7[c]));
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

}  // namespace
}  // namespace im2fit::body
