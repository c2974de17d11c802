// SPDX-License-Identifier: Apache-2.0
// DEPTH16 of Android's cameras (ImageFormat.DEPTH16): 13 bits of millimetres under 3 bits of confidence.
#pragma once

#include <cstddef>
#include <cstdint>

namespace im2fit::hal {

inline constexpr int kDepth16SureSevenths = 7;

// How sure the phone is, in sevenths: the field's 0 stands for 100 %, 1 for 0 %, 2 for 1/7 and so on to 7 for 6/7.
constexpr int depth16_confidence_sevenths(std::uint16_t sample) {
  const int field = sample >> 13;
  return field == 0 ? kDepth16SureSevenths : field - 1;
}

// Millimetres, 0 (no data) where the phone's confidence is below `sevenths_min` (0: takes everything, 7: only full
// confidence).
constexpr std::uint16_t depth16_mm(std::uint16_t sample, int sevenths_min) {
  return depth16_confidence_sevenths(sample) >= sevenths_min ? static_cast<std::uint16_t>(sample & 0x1FFF)
                                                             : std::uint16_t{0};
}

// `count` samples; `in` and `mm` may be the same.
inline void depth16_to_mm(const std::uint16_t* in, std::size_t count, int sevenths_min, std::uint16_t* mm) {
  for (std::size_t i = 0; i < count; ++i) mm[i] = depth16_mm(in[i], sevenths_min);
}

}  // namespace im2fit::hal
