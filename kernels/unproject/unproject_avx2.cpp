// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/unproject/unproject.h"

namespace im2fit {
namespace {

constexpr int kLanes = 8;

// (a b + 2^30) >> 31 in each lane: vqrdmulh where nothing saturates, and a depth is never the least integer.
__m256i rounding_product(__m256i a, __m256i b) {
  const __m256i half = _mm256_set1_epi64x(std::int64_t{1} << 30);
  const __m256i even = _mm256_add_epi64(_mm256_mul_epi32(a, b), half);
  const __m256i odd = _mm256_add_epi64(_mm256_mul_epi32(_mm256_srli_epi64(a, 32), _mm256_srli_epi64(b, 32)), half);
  return _mm256_blend_epi32(_mm256_srli_epi64(even, 31), _mm256_slli_epi64(odd, 1), 0xAA);
}

__m256 coordinate(__m256i raw) {
  return _mm256_mul_ps(_mm256_cvtepi32_ps(raw), _mm256_set1_ps(1.0F / (1 << CoordinateMm::kFractionBits)));
}

struct Shifts {
  __m128i to_depth, to_coordinate;
};

void eight(__m128i raw, __m256i column, __m256i row, const Shifts& shift, float* x, float* y, float* z) {
  const __m256i depth = _mm256_cvtepu16_epi32(raw);
  const __m256i product_depth = _mm256_sll_epi32(depth, shift.to_depth);
  const __m256 none = _mm256_castsi256_ps(_mm256_cmpeq_epi32(depth, _mm256_setzero_si256()));
  const __m256 nan = _mm256_castsi256_ps(_mm256_set1_epi32(0x7FC00000));
  const auto store = [&](float* out, __m256i value) {
    _mm256_storeu_ps(out, _mm256_blendv_ps(coordinate(value), nan, none));
  };
  store(x, rounding_product(column, product_depth));
  store(y, rounding_product(row, product_depth));
  store(z, _mm256_sll_epi32(depth, shift.to_coordinate));
}

}  // namespace

void unproject_avx2(DepthView depth, int fraction_bits, const RayTable& rays, float* x, float* y, float* z) {
  const std::int32_t* columns = rays.column_raws();
  const std::int32_t* rows = rays.row_raws();
  const Shifts shift = {_mm_cvtsi32_si128(12 - fraction_bits), _mm_cvtsi32_si128(10 - fraction_bits)};
  for (int v = 0; v < depth.height; ++v) {
    const std::uint16_t* in = depth.pixels + std::ptrdiff_t{v} * depth.stride;
    const __m256i row = _mm256_set1_epi32(rows[v]);
    int u = 0;
    for (; u + kLanes <= depth.width; u += kLanes) {
      eight(_mm_loadu_si128(reinterpret_cast<const __m128i*>(in + u)),
            _mm256_loadu_si256(reinterpret_cast<const __m256i*>(columns + u)), row, shift, x + u, y + u, z + u);
    }
    if (u < depth.width) {
      std::uint16_t raw[kLanes] = {};
      std::int32_t column[kLanes] = {};
      float out[3][kLanes];
      const int left = depth.width - u;
      for (int i = 0; i < left; ++i) {
        raw[i] = in[u + i];
        column[i] = columns[u + i];
      }
      eight(_mm_loadu_si128(reinterpret_cast<const __m128i*>(raw)),
            _mm256_loadu_si256(reinterpret_cast<const __m256i*>(column)), row, shift, out[0], out[1], out[2]);
      for (int i = 0; i < left; ++i) {
        x[u + i] = out[0][i];
        y[u + i] = out[1][i];
        z[u + i] = out[2][i];
      }
    }
    x += depth.width;
    y += depth.width;
    z += depth.width;
  }
}

}  // namespace im2fit
