// SPDX-License-Identifier: Apache-2.0
// The smooth set of modifiers that carries a body past the weight slider's ends (docs/makehuman.md).
#pragma once

#include <string_view>

namespace im2fit::body {

struct FatnessPart {
  std::string_view modifier;
  float share;
};
inline constexpr FatnessPart kFatness[] = {
    {"torso/torso-scale-horiz", 0.6F}, {"torso/torso-scale-depth", 0.8F},  {"hip/hip-scale-horiz", 0.7F},
    {"hip/hip-scale-depth", 0.8F},     {"armslegs/upperleg-fat", 1.0F},    {"armslegs/upperarm-fat", 1.0F},
    {"armslegs/lowerleg-fat", 0.8F},   {"stomach/stomach-pregnant", 0.3F}, {"buttocks/buttocks-volume", 0.6F},
};
inline constexpr float kFatnessMax = 1.6F;   // beyond it folds tear
inline constexpr float kSlimnessMax = 0.5F;  // the set's other side: muscular people are too heavy without

}  // namespace im2fit::body
