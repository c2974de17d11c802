// SPDX-License-Identifier: Apache-2.0
// IEEE 754 binary16, by integers alone: the same bits on every machine.
#pragma once

#include <bit>
#include <cstdint>

namespace im2fit::lab {

// Nearest, ties to even; beyond 65504 infinity; NaN stays NaN.
constexpr std::uint16_t half_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000U;
  const std::uint32_t size = bits & 0x7FFFFFFFU;
  if (size > 0x7F800000U) return static_cast<std::uint16_t>(sign | 0x7E00U);
  if (size >= 0x47800000U) return static_cast<std::uint16_t>(sign | 0x7C00U);  // 65536 and more
  const int exponent = static_cast<int>(size >> 23) - 127;
  if (exponent < -25) return static_cast<std::uint16_t>(sign);
  // Below 2^-14 the step no longer shrinks: more bits fall away, the leading one is written out.
  const bool small = exponent < -14;
  const std::uint32_t significand = small ? (size & 0x7FFFFFU) | 0x800000U : size - (112U << 23);
  const int dropped = small ? 13 + (-14 - exponent) : 13;
  const std::uint32_t rest = significand & ((1U << dropped) - 1);
  const std::uint32_t halfway = 1U << (dropped - 1);
  std::uint32_t kept = significand >> dropped;
  if (rest > halfway || (rest == halfway && (kept & 1U) != 0)) ++kept;  // may carry into the exponent, rightly
  return static_cast<std::uint16_t>(sign | kept);
}

constexpr float float_of(std::uint16_t half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16;
  const std::uint32_t exponent = half >> 10 & 0x1FU;
  const std::uint32_t significand = half & 0x3FFU;
  if (exponent == 0) {  // zero and what lies below 2^-14: exact in float
    const float size = static_cast<float>(significand) * 0x1p-24F;
    return std::bit_cast<float>(sign | std::bit_cast<std::uint32_t>(size));
  }
  const std::uint32_t wide = exponent == 31 ? 0x7F800000U : (exponent + 112) << 23;
  return std::bit_cast<float>(sign | wide | significand << 13);
}

}  // namespace im2fit::lab
