// SPDX-License-Identifier: Apache-2.0
// The clothing specified for a person before a measurement.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace im2fit {

// unknown: estimated from the frames. bare: underwear or close-fitting sportswear. dressed: more than that.
enum class ClothingGiven : std::uint8_t { unknown, bare, dressed };
inline constexpr std::size_t kClothingGivenCount = 3;
inline constexpr std::array<std::string_view, kClothingGivenCount> kClothingGivenNames = {"auto", "bare", "dressed"};

// The value of a name; unknown for any other text.
constexpr ClothingGiven clothing_of(std::string_view name) {
  for (std::size_t i = 0; i < kClothingGivenCount; ++i)
    if (kClothingGivenNames[i] == name) return static_cast<ClothingGiven>(i);
  return ClothingGiven::unknown;
}
constexpr std::string_view name_of(ClothingGiven given) {
  return kClothingGivenNames[static_cast<std::size_t>(given)];
}

}  // namespace im2fit
