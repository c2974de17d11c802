// SPDX-License-Identifier: Apache-2.0
#include <immintrin.h>

#include "kernels/unpack11/unpack11.h"

namespace im2fit {
namespace {

// Eight values from the 11 bytes at `p`, of which 16 are read. A value lies within three bytes: they go, the first on
// top, into 32 bits, and are shifted down.
__m256i eight(const std::uint8_t* p) {
  const __m256i order = _mm256_setr_epi8(-1, 2, 1, 0, -1, 3, 2, 1, -1, 4, 3, 2, -1, 6, 5, 4,  //
                                         -1, 7, 6, 5, -1, 8, 7, 6, -1, 10, 9, 8, -1, -1, 10, 9);
  const __m256i down = _mm256_setr_epi32(21, 18, 15, 20, 17, 14, 19, 16);
  const __m256i bytes = _mm256_broadcastsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
  return _mm256_and_si256(_mm256_srlv_epi32(_mm256_shuffle_epi8(bytes, order), down), _mm256_set1_epi32(0x7FF));
}

}  // namespace

void unpack11_avx2(const std::uint8_t* packed, int count, std::uint16_t* out) {
  // The second eight read five bytes beyond their own: half a group more must follow.
  while (count >= 16 + 4) {
    const __m256i lanes = _mm256_packus_epi32(eight(packed), eight(packed + 11));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_permute4x64_epi64(lanes, 0xD8));
    packed += 22;
    out += 16;
    count -= 16;
  }
  unpack11_portable(packed, count, out);
}

}  // namespace im2fit
