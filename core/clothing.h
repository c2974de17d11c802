// SPDX-License-Identifier: Apache-2.0
// What is said of a person's clothes before a measurement.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace im2fit {

// Nothing: they are estimated from the frames; underwear or close-fitting sportswear; more than that.
enum class ClothingGiven : std::uint8_t { unknown, bare, dressed };
inline constexpr std::size_t kClothingGivenCount = 3;
inline constexpr std::array<std::string_view, kClothingGivenCount> kClothingGivenNames = {"auto", "bare", "dressed"};

// Of a name; of another, unknown.
constexpr ClothingGiven clothing_of(std::string_view name) {
  for (std::size_t i = 0; i < kClothingGivenCount; ++i)
    if (kClothingGivenNames[i] == name) return static_cast<ClothingGiven>(i);
  return ClothingGiven::unknown;
}
constexpr std::string_view name_of(ClothingGiven given) {
  return kClothingGivenNames[static_cast<std::size_t>(given)];
}

}  // namespace im2fit
