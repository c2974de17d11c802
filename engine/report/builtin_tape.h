// SPDX-License-Identifier: Apache-2.0
// The texts of data/tape/, in the order in which they are read.
#pragma once

#include <array>
#include <cstddef>

namespace im2fit {

struct BuiltinTapeText {
  const char* file;
  const char* text;
};
inline constexpr std::size_t kBuiltinTapeTexts = 4;
extern const std::array<BuiltinTapeText, kBuiltinTapeTexts> kBuiltinTape;

}  // namespace im2fit
