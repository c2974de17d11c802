// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/anchors/one_anchor.h"

namespace im2fit::joints {
namespace {

constexpr int kLanes = 8;

__m256i load(const void* p) {
  return _mm256_loadu_si256(static_cast<const __m256i*>(p));
}
// Every other 32-bit word of eight anchors, in their order.
__m256i words(__m256i low, __m256i high, bool second) {
  const __m256 a = _mm256_castsi256_ps(low), b = _mm256_castsi256_ps(high);
  const __m256 mixed = second ? _mm256_shuffle_ps(a, b, 0xDD) : _mm256_shuffle_ps(a, b, 0x88);
  return _mm256_permute4x64_epi64(_mm256_castps_si256(mixed), 0xD8);
}
// table[index], of 16.
__m256 look_up(const float* table, __m256i index) {
  const __m256 low = _mm256_permutevar8x32_ps(_mm256_load_ps(table), index);
  const __m256 high = _mm256_permutevar8x32_ps(_mm256_load_ps(table + kLanes), index);
  return _mm256_blendv_ps(low, high, _mm256_castsi256_ps(_mm256_slli_epi32(index, 28)));
}
__m256 between(const float* table, __m256i from, __m256i to, __m256 share) {
  const __m256 start = look_up(table, from);
  return _mm256_add_ps(start, _mm256_mul_ps(_mm256_sub_ps(look_up(table, to), start), share));
}
// Of the box, from a ray.
__m256i pixel(__m256 ray, float f, float c, int first) {
  const __m256 at = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(f), ray), _mm256_set1_ps(c));
  const __m256i shifted = _mm256_cvttps_epi32(_mm256_add_ps(at, _mm256_set1_ps(kFloorShift)));
  return _mm256_sub_epi32(shifted, _mm256_set1_epi32(kFloorUnshift + first));
}
__m256i below(__m256i value, int limit) {  // as unsigned numbers
  return _mm256_cmpeq_epi32(value, _mm256_min_epu32(value, _mm256_set1_epi32(limit - 1)));
}

void eight(const Anchor* anchors, const AnchorJoints& joints, const AnchorBox& box, std::int16_t* out,
           std::ptrdiff_t out_step) {
  const __m256i first = load(anchors), second = load(anchors + 4);
  const __m256i offset = words(first, second, false), rest = words(first, second, true);
  const __m256i byte = _mm256_set1_epi32(0xFF);
  const __m256i from = _mm256_and_si256(rest, byte), to = _mm256_and_si256(_mm256_srli_epi32(rest, 8), byte);
  const __m256 share = _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_srai_epi32(rest, 16)), _mm256_set1_ps(1.0F / 256.0F));
  const __m256 dx = _mm256_cvtepi32_ps(_mm256_srai_epi32(_mm256_slli_epi32(offset, 16), 16));
  const __m256 dy = _mm256_cvtepi32_ps(_mm256_srai_epi32(offset, 16));
  const __m256 scale = between(joints.inverse_z, from, to, share);
  const __m256 rx = _mm256_mul_ps(_mm256_add_ps(between(joints.x, from, to, share), dx), scale);
  const __m256 ry = _mm256_mul_ps(_mm256_add_ps(between(joints.y, from, to, share), dy), scale);
  const __m256i u = pixel(rx, box.fx, box.cx, box.u_first), v = pixel(ry, box.fy, box.cy, box.v_first);
  const __m256i inside = _mm256_and_si256(below(u, box.width), below(v, box.height));
  const __m256i place = _mm256_add_epi32(_mm256_mullo_epi32(v, _mm256_set1_epi32(box.width)), u);
  alignas(32) std::uint32_t at[kLanes];
  alignas(32) std::int32_t depth[kLanes];
  _mm256_store_si256(reinterpret_cast<__m256i*>(at), _mm256_and_si256(place, inside));
  for (int i = 0; i < kLanes; ++i) depth[i] = box.depth[at[i]];
  const __m256i d = _mm256_load_si256(reinterpret_cast<const __m256i*>(depth));
  const __m256i far = _mm256_set1_epi32(kAnchorFarMm);
  __m256i away = _mm256_sub_epi32(d, _mm256_set1_epi32(box.reference_mm));
  away = _mm256_max_epi32(_mm256_min_epi32(away, far), _mm256_set1_epi32(-kAnchorFarMm));
  const __m256i seen = _mm256_andnot_si256(_mm256_cmpeq_epi32(d, _mm256_setzero_si256()), inside);
  away = _mm256_blendv_epi8(far, away, seen);
  alignas(32) std::int32_t result[kLanes];
  _mm256_store_si256(reinterpret_cast<__m256i*>(result), away);
  for (int i = 0; i < kLanes; ++i) out[i * out_step] = static_cast<std::int16_t>(result[i]);
}

}  // namespace

void anchor_depths_avx2(const Anchor* anchors, int count, const AnchorJoints& joints, const AnchorBox& box,
                        std::int16_t* out, std::ptrdiff_t out_step) {
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) eight(anchors + i, joints, box, out + i * out_step, out_step);
  for (; i < count; ++i) out[i * out_step] = anchor_depth(anchors[i], joints, box);
}

}  // namespace im2fit::joints
