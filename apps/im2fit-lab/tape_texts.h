// SPDX-License-Identifier: Apache-2.0
// The files of data/tape, for packs, in the order in which they are read.
#pragma once

#include <array>
#include <cstddef>

namespace im2fit::apps {

struct TapeText {
  const char* file;
  const char* text;
};
inline constexpr std::size_t kTapeTextCount = 4;
extern const std::array<TapeText, kTapeTextCount> kTapeTexts;

}  // namespace im2fit::apps
