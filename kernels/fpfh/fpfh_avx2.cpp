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

struct Vectors {
  __m256 x, y, z;
};

__m256 dot(const Vectors& a, const Vectors& b) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a.x, b.x), _mm256_mul_ps(a.y, b.y)), _mm256_mul_ps(a.z, b.z));
}
Vectors load(const float* x, const float* y, const float* z, int at) {
  return {_mm256_loadu_ps(x + at), _mm256_loadu_ps(y + at), _mm256_loadu_ps(z + at)};
}
Vectors broadcast(const float* x, const float* y, const float* z, int at) {
  return {_mm256_broadcast_ss(x + at), _mm256_broadcast_ss(y + at), _mm256_broadcast_ss(z + at)};
}
Vectors difference(const Vectors& a, const Vectors& b) {
  return {_mm256_sub_ps(a.x, b.x), _mm256_sub_ps(a.y, b.y), _mm256_sub_ps(a.z, b.z)};
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
__m256i bin_of(__m256 f) {
  const __m256 half = _mm256_set1_ps(5.5F);
  const __m256 position = _mm256_add_ps(_mm256_mul_ps(f, half), half);
  return _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(position, _mm256_setzero_ps()), _mm256_set1_ps(10.0F)));
}

// Lanes within the radius that someone needs.
__m256 lanes_inside(const PairTask& task, int j, __m256 d2) {
  const __m256 inside = _mm256_cmp_ps(d2, _mm256_set1_ps(task.radius_squared), _CMP_LT_OQ);
  if (task.source_needed) return inside;
  const __m256i needed = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(task.needed + j)));
  return _mm256_and_ps(inside, _mm256_castsi256_ps(_mm256_cmpgt_epi32(needed, _mm256_setzero_si256())));
}

void leave_aside(PairTask& task, int j, __m256 lanes) {
  for (int left = _mm256_movemask_ps(lanes); left != 0; left &= left - 1)
    task.aside_list[task.aside_count++] = j + __builtin_ctz(static_cast<unsigned>(left));
}

// Codes of eight pairs; `sound` tells the lanes where they hold.
__m256i pair_codes(const Vectors& u, const Vectors& m, const Vectors& d, __m256 d2, __m256& sound) {
  const __m256 along1 = dot(u, d), along2 = dot(m, d), c = dot(u, m);
  const Vectors v = {_mm256_sub_ps(_mm256_mul_ps(d.y, u.z), _mm256_mul_ps(d.z, u.y)),
                     _mm256_sub_ps(_mm256_mul_ps(d.z, u.x), _mm256_mul_ps(d.x, u.z)),
                     _mm256_sub_ps(_mm256_mul_ps(d.x, u.y), _mm256_mul_ps(d.y, u.x))};
  const __m256 triple = dot(v, m);
  const __m256 size1 = size_of(along1), size2 = size_of(along2);
  const __m256 swap = _mm256_cmp_ps(size1, size2, _CMP_LT_OQ);
  const __m256 source = _mm256_blendv_ps(along1, negated(along2), swap);
  const __m256 target = _mm256_blendv_ps(along2, negated(along1), swap);
  const __m256 s = _mm256_sub_ps(d2, _mm256_mul_ps(source, source));
  const __m256 v_length = _mm256_sqrt_ps(_mm256_max_ps(s, _mm256_setzero_ps()));
  const __m256 d_length = _mm256_sqrt_ps(d2);
  const __m256 inverse = _mm256_div_ps(_mm256_set1_ps(1.0F), _mm256_mul_ps(v_length, d_length));
  const __m256i b2 = bin_of(_mm256_mul_ps(_mm256_mul_ps(triple, d_length), inverse));
  const __m256i b3 = bin_of(_mm256_mul_ps(_mm256_mul_ps(source, v_length), inverse));
  const __m256 wt = _mm256_sub_ps(target, _mm256_mul_ps(source, c));
  const __m256 across = size_of(wt), cl = _mm256_mul_ps(c, v_length);
  // Minus the number of edges passed. a - b > 0 where a > b: floats underflow gradually.
  __m256i passed = _mm256_setzero_si256();
  for (int k = 0; k < fpfh_detail::kEdgeCount; ++k) {
    const __m256 above = greater(_mm256_mul_ps(across, _mm256_load_ps(fpfh_detail::kVectorConstants.cosine[k])),
                                 _mm256_mul_ps(cl, _mm256_load_ps(fpfh_detail::kVectorConstants.sine[k])));
    passed = _mm256_add_epi32(passed, _mm256_castps_si256(above));
  }
  // 5 + passed, or 5 - passed where w.target is below zero.
  const __m256i below = _mm256_castps_si256(_mm256_cmp_ps(wt, _mm256_setzero_ps(), _CMP_LT_OQ));
  const __m256i minus = _mm256_sub_epi32(_mm256_xor_si256(passed, below), below);
  const __m256i b1 = _mm256_sub_epi32(_mm256_set1_epi32(5), minus);
  const __m256 tie = _mm256_mul_ps(_mm256_set1_ps(fpfh_detail::kNearTie), d_length);
  sound = _mm256_and_ps(greater(s, _mm256_mul_ps(_mm256_set1_ps(fpfh_detail::kNearlyParallel), d2)),
                        greater(size_of(_mm256_sub_ps(size1, size2)), tie));
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
  asm("" : "+m"(offsets));  // lanes come cheaper from memory than out of the register
  __m256i sum = _mm256_setzero_si256();
  for (int t = 0; t < kLanes; ++t) {
    const __m256i one = _mm256_load_si256(reinterpret_cast<const __m256i*>(kIncrements.bytes + offsets[t]));
    sum = _mm256_add_epi8(sum, one);
    __m256i* at = reinterpret_cast<__m256i*>(bytes + t * kCountBytes);
    _mm256_storeu_si256(at, _mm256_add_epi8(_mm256_loadu_si256(at), one));
  }
  return sum;
}

// The source has a normal, the candidates of some lanes have none.
void count_blank_candidates(PairTask& task, int j, __m256 lanes, const Vectors& u, const Vectors& d, __m256 d2) {
  alignas(32) std::int32_t f3[kLanes];
  _mm256_store_si256(reinterpret_cast<__m256i*>(f3), bin_of(_mm256_div_ps(dot(u, d), _mm256_sqrt_ps(d2))));
  std::int32_t* own = task.counts + static_cast<long>(task.source) * kFpfhSize;
  for (int left = _mm256_movemask_ps(lanes); left != 0; left &= left - 1) {
    const int t = __builtin_ctz(static_cast<unsigned>(left));
    std::int32_t* other = task.counts + static_cast<long>(j + t) * kFpfhSize;
    ++own[0], ++own[kFpfhBins], ++own[2 * kFpfhBins + f3[t]];
    ++other[0], ++other[kFpfhBins], ++other[2 * kFpfhBins];
  }
}

void count_pairs(PairTask& task) {
  const Vectors p = broadcast(task.x, task.y, task.z, task.source);
  const Vectors u = broadcast(task.nx, task.ny, task.nz, task.source);
  std::int32_t* const own_counts = task.counts + static_cast<long>(task.source) * kFpfhSize;
  __m256i own = _mm256_setzero_si256();
  int blocks = 0;
  for (int r = 0; r < task.range_count; ++r) {
    const int end = task.ranges[2 * r + 1];
    for (int j = task.ranges[2 * r]; j < end; j += kLanes) {
      const Vectors d = difference(load(task.x, task.y, task.z, j), p);
      const __m256 d2 = dot(d, d);
      const __m256 inside = lanes_inside(task, j, d2);
      if (_mm256_testz_ps(inside, inside)) continue;
      const Vectors m = load(task.nx, task.ny, task.nz, j);
      __m256 sound;
      const __m256i codes = pair_codes(u, m, d, d2, sound);
      // A missing normal is NaN, which is not sound.
      const __m256 counted = _mm256_and_ps(inside, sound);
      if (!_mm256_testc_ps(sound, inside)) {
        const __m256 unsound = _mm256_andnot_ps(sound, inside);
        const __m256 blank = _mm256_and_ps(_mm256_and_ps(unsound, _mm256_cmp_ps(m.x, m.x, _CMP_UNORD_Q)),
                                           greater(d2, _mm256_setzero_ps()));
        count_blank_candidates(task, j, blank, u, d, d2);
        leave_aside(task, j, _mm256_andnot_ps(blank, unsound));
      }
      own = _mm256_add_epi8(
          own, count_codes(_mm256_blendv_epi8(_mm256_set1_epi32(kNoPair), codes, _mm256_castps_si256(counted)),
                           task.count_bytes + static_cast<long>(j) * kCountBytes));
      if (++blocks == kBlocksUntilOverflow) {
        add_bytes(own, own_counts);
        own = _mm256_setzero_si256();
        blocks = 0;
      }
    }
  }
  add_bytes(own, own_counts);
}

void count_blank_pairs(PairTask& task) {
  const Vectors p = broadcast(task.x, task.y, task.z, task.source);
  int counted = 0;
  for (int r = 0; r < task.range_count; ++r) {
    const int end = task.ranges[2 * r + 1];
    for (int j = task.ranges[2 * r]; j < end; j += kLanes) {
      const Vectors d = difference(load(task.x, task.y, task.z, j), p);
      const __m256 d2 = dot(d, d);
      const __m256 inside = lanes_inside(task, j, d2);
      if (_mm256_testz_ps(inside, inside)) continue;
      const __m256 apart = _mm256_and_ps(inside, greater(d2, _mm256_setzero_ps()));
      leave_aside(task, j, _mm256_andnot_ps(apart, inside));
      // Seen from the candidate the line points the other way. No normal there either: NaN, bin 0.
      const __m256 along = negated(dot(load(task.nx, task.ny, task.nz, j), d));
      const __m256i codes = _mm256_slli_epi32(bin_of(_mm256_div_ps(along, _mm256_sqrt_ps(d2))), 5);
      count_codes(_mm256_blendv_epi8(_mm256_set1_epi32(kNoPair), codes, _mm256_castps_si256(apart)),
                  task.count_bytes + static_cast<long>(j) * kCountBytes);
      counted += __builtin_popcount(static_cast<unsigned>(_mm256_movemask_ps(apart)));
    }
  }
  std::int32_t* own = task.counts + static_cast<long>(task.source) * kFpfhSize;
  own[0] += counted, own[kFpfhBins] += counted, own[2 * kFpfhBins] += counted;
}

}  // namespace

void fpfh_avx2(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
               std::span<float> out) {
  fpfh_detail::fpfh_in_blocks(cloud, keypoints, radius_mm, work, out, {count_pairs, count_blank_pairs});
}

}  // namespace im2fit
