// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/edge/edge_border.h"

namespace im2fit {
namespace {

constexpr int kLanes = 16;

struct Answer {
  __m256i far, near;  // all ones where a neighbour was
};

__m256i load(const std::uint16_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}

void look(__m256i z, __m256i limit, const std::uint16_t* p, bool straight, Answer& answer) {
  const __m256i other = load(p), zero = _mm256_setzero_si256();
  const __m256i away = _mm256_or_si256(_mm256_subs_epu16(z, other), _mm256_subs_epu16(other, z));
  const __m256i within = _mm256_cmpeq_epi16(_mm256_subs_epu16(away, limit), zero);
  const __m256i none = _mm256_cmpeq_epi16(other, zero);
  answer.near = _mm256_or_si256(answer.near, _mm256_andnot_si256(none, within));
  if (straight)
    answer.far =
        _mm256_or_si256(answer.far, _mm256_andnot_si256(_mm256_or_si256(within, none), _mm256_set1_epi16(-1)));
}

// -1 where an edge is.
__m256i sixteen(const std::uint16_t* p, std::ptrdiff_t stride) {
  const __m256i z = load(p);
  const __m256i quanta = _mm256_mulhi_epu16(_mm256_mulhi_epu16(z, z), _mm256_set1_epi16(18361));
  const __m256i limit = _mm256_add_epi16(quanta, _mm256_set1_epi16(40));
  Answer answer = {_mm256_setzero_si256(), _mm256_setzero_si256()};
  look(z, limit, p - stride, true, answer);
  look(z, limit, p + stride, true, answer);
  look(z, limit, p - 1, true, answer);
  look(z, limit, p + 1, true, answer);
  look(z, limit, p - stride - 1, false, answer);
  look(z, limit, p - stride + 1, false, answer);
  look(z, limit, p + stride - 1, false, answer);
  look(z, limit, p + stride + 1, false, answer);
  const __m256i all = _mm256_set1_epi16(-1);
  const __m256i edge = _mm256_or_si256(answer.far, _mm256_andnot_si256(answer.near, all));
  return _mm256_andnot_si256(_mm256_cmpeq_epi16(z, _mm256_setzero_si256()), edge);
}

}  // namespace

void edge_avx2(DepthView depth, MaskImage mask) {
  for (int v = 0; v < depth.height; ++v) {
    const std::uint16_t* in = depth.pixels + std::ptrdiff_t{v} * depth.stride;
    std::uint8_t* out = mask.pixels + std::ptrdiff_t{v} * mask.stride;
    int u = 0;
    if (v > 0 && v + 1 < depth.height && depth.width >= kLanes + 2) {
      edge_pixels(depth, mask, v, 0, 1);
      for (u = 1; u + kLanes + 1 <= depth.width; u += kLanes) {
        const __m256i edge = sixteen(in + u, depth.stride);
        _mm_storeu_si128(reinterpret_cast<__m128i*>(out + u),
                         _mm_packs_epi16(_mm256_castsi256_si128(edge), _mm256_extracti128_si256(edge, 1)));
      }
    }
    edge_pixels(depth, mask, v, u, depth.width);
  }
}

}  // namespace im2fit
