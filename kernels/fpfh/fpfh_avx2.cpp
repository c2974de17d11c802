// SPDX-License-Identifier: Apache-2.0
// Eight pairs at a time: the arithmetic of fpfh_portable.cpp's block_bins in its order, lane by lane.
#include <immintrin.h>

#include "kernels/fpfh/fpfh_blocks.h"
#include "kernels/fpfh/fpfh_constants.h"

namespace im2fit {
namespace {

using fpfh_detail::kCountBytes;
using fpfh_detail::kIncrements;
using fpfh_detail::kNoPair;
using fpfh_detail::PairTask;

constexpr int kLanes = 8;
constexpr int kBlocksUntilOverflow = fpfh_detail::kLanesUntilOverflow / kLanes;

struct Source {
  __m256 x, y, z, nx, ny, nz;
};

__m256 dot(__m256 ax, __m256 ay, __m256 az, __m256 bx, __m256 by, __m256 bz) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(ax, bx), _mm256_mul_ps(ay, by)), _mm256_mul_ps(az, bz));
}

__m256 negated(__m256 a) {
  return _mm256_xor_ps(a, _mm256_set1_ps(-0.0F));
}
__m256 size_of(__m256 a) {
  return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), a);
}
__m256 greater(__m256 a, __m256 b) {
  return _mm256_cmp_ps(a, b, _CMP_GT_OQ);
}

// 11 (f + 1) / 2 as an integer in 0..10; NaN gives 0.
__m256i clamped(__m256 position) {
  return _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(position, _mm256_setzero_ps()), _mm256_set1_ps(10.0F)));
}

// Codes of eight pairs; `careful` gets those lanes that the careful path must decide.
__m256i pair_codes(const Source& p, __m256 dx, __m256 dy, __m256 dz, __m256 d2, const float* nx, const float* ny,
                   const float* nz, __m256& careful) {
  const __m256 mx = _mm256_loadu_ps(nx), my = _mm256_loadu_ps(ny), mz = _mm256_loadu_ps(nz);
  const __m256 along1 = dot(p.nx, p.ny, p.nz, dx, dy, dz);
  const __m256 along2 = dot(mx, my, mz, dx, dy, dz);
  const __m256 c = dot(p.nx, p.ny, p.nz, mx, my, mz);
  const __m256 vx = _mm256_sub_ps(_mm256_mul_ps(dy, p.nz), _mm256_mul_ps(dz, p.ny));
  const __m256 vy = _mm256_sub_ps(_mm256_mul_ps(dz, p.nx), _mm256_mul_ps(dx, p.nz));
  const __m256 vz = _mm256_sub_ps(_mm256_mul_ps(dx, p.ny), _mm256_mul_ps(dy, p.nx));
  const __m256 triple = dot(vx, vy, vz, mx, my, mz);
  const __m256 size1 = size_of(along1), size2 = size_of(along2);
  const __m256 swap = _mm256_cmp_ps(size1, size2, _CMP_LT_OQ);
  const __m256 source = _mm256_blendv_ps(along1, negated(along2), swap);
  const __m256 target = _mm256_blendv_ps(along2, negated(along1), swap);
  const __m256 s = _mm256_sub_ps(d2, _mm256_mul_ps(source, source));
  const __m256 v_length = _mm256_sqrt_ps(_mm256_max_ps(s, _mm256_setzero_ps()));
  const __m256 d_length = _mm256_sqrt_ps(d2);
  const __m256 inverse = _mm256_div_ps(_mm256_set1_ps(1.0F), _mm256_mul_ps(v_length, d_length));
  const __m256 tie = _mm256_mul_ps(_mm256_set1_ps(fpfh_detail::kNearTie), d_length);
  const __m256 half = _mm256_set1_ps(5.5F);
  const __m256 f2 = _mm256_add_ps(_mm256_mul_ps(_mm256_mul_ps(_mm256_mul_ps(triple, d_length), inverse), half), half);
  const __m256 f3 = _mm256_add_ps(_mm256_mul_ps(_mm256_mul_ps(_mm256_mul_ps(source, v_length), inverse), half), half);
  const __m256 wt = _mm256_sub_ps(target, _mm256_mul_ps(source, c));
  const __m256 across = size_of(wt);
  const __m256 cl = _mm256_mul_ps(c, v_length);
  // Minus the number of edges passed. a - b > 0 where a > b: floats underflow gradually.
  __m256i passed = _mm256_setzero_si256();
  for (int k = 0; k < fpfh_detail::kEdgeCount; ++k) {
    const __m256 above = greater(_mm256_mul_ps(across, _mm256_set1_ps(fpfh_detail::kEdgeCosine[k])),
                                 _mm256_mul_ps(cl, _mm256_set1_ps(fpfh_detail::kEdgeSine[k])));
    passed = _mm256_add_epi32(passed, _mm256_castps_si256(above));
  }
  // 5 + passed, or 5 - passed where w.target is below zero.
  const __m256i below = _mm256_castps_si256(_mm256_cmp_ps(wt, _mm256_setzero_ps(), _CMP_LT_OQ));
  const __m256i minus_signed = _mm256_sub_epi32(_mm256_xor_si256(passed, below), below);
  const __m256i b1 = _mm256_sub_epi32(_mm256_set1_epi32(5), minus_signed);
  const __m256i b2 = clamped(f2), b3 = clamped(f3);
  const __m256 sound = _mm256_and_ps(greater(s, _mm256_mul_ps(_mm256_set1_ps(fpfh_detail::kNearlyParallel), d2)),
                                     _mm256_cmp_ps(size_of(_mm256_sub_ps(size1, size2)), tie, _CMP_GT_OQ));
  careful = _mm256_andnot_ps(sound, _mm256_castsi256_ps(_mm256_set1_epi32(-1)));
  // (b1 * 121 + b2 * 11 + b3) * 32.
  const __m256i first_two = _mm256_madd_epi16(_mm256_or_si256(b1, _mm256_slli_epi32(b2, 16)),
                                              _mm256_set1_epi32(kFpfhBins * kFpfhBins | kFpfhBins << 16));
  return _mm256_slli_epi32(_mm256_add_epi32(first_two, b3), 5);
}

void add_bytes(__m256i bytes, std::int32_t* counts) {
  alignas(32) std::uint8_t values[kCountBytes];
  _mm256_store_si256(reinterpret_cast<__m256i*>(values), bytes);
  for (int b = 0; b < kCountBytes; b += 8) {
    const __m256i wide = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(values + b)));
    __m256i* at = reinterpret_cast<__m256i*>(counts + b);
    _mm256_storeu_si256(at, _mm256_add_epi32(_mm256_loadu_si256(at), wide));
  }
}

// Counts eight pairs at their candidates and returns their sum.
__m256i count_codes(__m256i codes, std::uint8_t* bytes) {
  alignas(32) std::uint32_t offsets[kLanes];
  _mm256_store_si256(reinterpret_cast<__m256i*>(offsets), codes);
  __m256i sum = _mm256_setzero_si256();
  for (int t = 0; t < kLanes; ++t) {
    const __m256i one = _mm256_load_si256(reinterpret_cast<const __m256i*>(kIncrements.bytes + offsets[t]));
    sum = _mm256_add_epi8(sum, one);
    __m256i* at = reinterpret_cast<__m256i*>(bytes + t * kCountBytes);
    _mm256_storeu_si256(at, _mm256_add_epi8(_mm256_loadu_si256(at), one));
  }
  return sum;
}

void count_pairs(PairTask& task) {
  const int i = task.source;
  const Source p = {_mm256_set1_ps(task.x[i]),  _mm256_set1_ps(task.y[i]),  _mm256_set1_ps(task.z[i]),
                    _mm256_set1_ps(task.nx[i]), _mm256_set1_ps(task.ny[i]), _mm256_set1_ps(task.nz[i])};
  const __m256 radius_squared = _mm256_set1_ps(task.radius_squared);
  __m256i own = _mm256_setzero_si256();
  int blocks = 0;
  for (int r = 0; r < task.range_count; ++r) {
    const int end = task.ranges[2 * r + 1];
    for (int j = task.ranges[2 * r]; j < end; j += kLanes) {
      const __m256 dx = _mm256_sub_ps(_mm256_loadu_ps(task.x + j), p.x);
      const __m256 dy = _mm256_sub_ps(_mm256_loadu_ps(task.y + j), p.y);
      const __m256 dz = _mm256_sub_ps(_mm256_loadu_ps(task.z + j), p.z);
      const __m256 d2 = dot(dx, dy, dz, dx, dy, dz);
      __m256 inside = _mm256_cmp_ps(d2, radius_squared, _CMP_LT_OQ);
      if (!task.source_needed) {
        const __m256i needed =
            _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(task.needed + j)));
        inside = _mm256_and_ps(inside, _mm256_castsi256_ps(_mm256_cmpgt_epi32(needed, _mm256_setzero_si256())));
      }
      if (_mm256_testz_ps(inside, inside)) continue;
      __m256 careful;
      const __m256i codes = pair_codes(p, dx, dy, dz, d2, task.nx + j, task.ny + j, task.nz + j, careful);
      // A missing normal is NaN, which makes a pair look careful.
      const __m256 aside = _mm256_and_ps(inside, careful);
      if (!_mm256_testz_ps(aside, aside)) {
        for (int lanes = _mm256_movemask_ps(aside); lanes != 0; lanes &= lanes - 1)
          task.aside_list[task.aside_count++] = j + __builtin_ctz(static_cast<unsigned>(lanes));
      }
      const __m256i counted = _mm256_castps_si256(_mm256_andnot_ps(careful, inside));
      own = _mm256_add_epi8(own, count_codes(_mm256_blendv_epi8(_mm256_set1_epi32(kNoPair), codes, counted),
                                             task.count_bytes + static_cast<long>(j) * kCountBytes));
      if (++blocks == kBlocksUntilOverflow) {
        add_bytes(own, task.own_counts);
        own = _mm256_setzero_si256();
        blocks = 0;
      }
    }
  }
  add_bytes(own, task.own_counts);
}

}  // namespace

void fpfh_avx2(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
               std::span<float> out) {
  fpfh_detail::fpfh_in_blocks(cloud, keypoints, radius_mm, work, out, count_pairs);
}

}  // namespace im2fit
