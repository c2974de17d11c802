// SPDX-License-Identifier: Apache-2.0
// The innermost loop of the structured-light sensor: noise onto a row of disparities. The same bits in every variant.
#pragma once

#include <cstdint>

#include "kernels/tier.h"

namespace im2fit::lab {

// SplitMix64's step: `seed + k kRowStep` is the state before the k-th draw of a row.
inline constexpr std::uint64_t kRowStep = 0x9E3779B97F4A7C15ULL;

// Bits of a pixel's draw, hashed once more for its chance of no data: 16 bits.
inline constexpr std::uint64_t kChanceFactor = 0xD1342543DE82EF95ULL;
constexpr std::int32_t chance_of_bits(std::uint64_t bits) {
  return static_cast<std::int32_t>((bits * kChanceFactor) >> 48);
}

// About normal (as Rng::fast_normal), on given bits.
inline float normal_of_bits(std::uint64_t r) {
  const int sum = static_cast<int>(r & 0xFFFF) + static_cast<int>((r >> 16) & 0xFFFF) +
                  static_cast<int>((r >> 32) & 0xFFFF) + static_cast<int>(r >> 48);
  return (static_cast<float>(sum) - 131070.0F) * (1.7320508F / 65536.0F);
}

inline constexpr int kRawCount = 2048;  // steps of the sensor's 11 bits

// A single pixel, from its draw's bits: as the rows below.
struct RawPixel {
  std::uint64_t bits;
  float exact, sigma;
  std::int32_t lost;
  float patch, white_share, patch_share;
};
inline std::int32_t raw_step(const RawPixel& p) {
  const float raw = p.exact + p.sigma * (p.white_share * normal_of_bits(p.bits) + p.patch_share * p.patch);
  const float up = raw + 0.5F;
  const float last = static_cast<float>(kRawCount - 1);
  // Nearer than the sensor can express (raw < -0.5) is as lost as farther.
  const bool delivered = (chance_of_bits(p.bits) >= p.lost) & (raw >= -0.5F);
  return delivered ? static_cast<std::int32_t>(up < last ? up : last) : kRawCount;
}

// What is known of a row before noise, from its first pixel on; and the row of noise that patches share.
struct RawRow {
  std::uint64_t seed;        // of the first pixel's draw
  const float* exact;        // raw units
  const float* sigma;        // spread, raw units
  const std::int32_t* lost;  // chance of no data, of 65536
  const float* patch;        // standard normal
  float white_share;         // of the spread: each pixel's own
  float patch_share;
};

// out[i]: the step delivered, 0 .. kRawCount - 1, or kRawCount for no data.
using RawRowFunction = void(const RawRow& row, int count, std::int32_t* out);
RawRowFunction raw_row_portable, raw_row_avx2;  // the latter where IM2FIT_HAVE_AVX2
RawRowFunction* fastest_raw_row();

}  // namespace im2fit::lab
