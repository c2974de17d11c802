// SPDX-License-Identifier: Apache-2.0
#include "train/population/shape_spread.h"

#include <algorithm>
#include <cstddef>
#include <string>

namespace im2fit::body {
namespace {

// Spreads chosen so that what stature and mass leave unexplained comes near ANSUR II (men/women, mm: chest 32/43,
// waist 45/49, hip 26/29, neck 15/12, thigh 22/22, crotch height 23/23).
constexpr ModifierSpread kSpreads[] = {
    {"measure/measure-waist-circ", 0.36F, 0.36F, 0.00F, 0.55F},
    {"measure/measure-bust-circ", 0.12F, 0.12F, 0.00F, -0.05F},
    {"measure/measure-underbust-circ", 0.15F, 0.15F},
    {"measure/measure-hips-circ", 0.08F, 0.08F, -0.15F, -0.15F},
    {"measure/measure-neck-circ", 0.18F, 0.12F, 0.35F, 0.20F},
    {"measure/measure-neck-height", 0.20F, 0.20F},
    {"measure/measure-shoulder-dist", 0.12F, 0.12F, 0.00F, -0.40F},
    {"measure/measure-thigh-circ", 0.20F, 0.20F},
    {"measure/measure-calf-circ", 0.25F, 0.25F},
    {"measure/measure-upperarm-circ", 0.15F, 0.15F},
    {"measure/measure-upperarm-length", 0.16F, 0.16F, 0.25F, 0.40F},
    {"measure/measure-lowerarm-length", 0.16F, 0.16F, 0.25F, 0.40F},
    {"measure/measure-upperleg-height", 0.25F, 0.25F, 0.00F, 0.25F},
    {"measure/measure-lowerleg-height", 0.25F, 0.25F, 0.00F, 0.25F},
    {"hip/hip-scale-horiz", 0.10F, 0.10F, -0.50F, -0.50F},
    {"hip/hip-scale-depth", 0.12F, 0.12F, -0.10F, -0.10F},
    {"torso/torso-scale-horiz", 0.15F, 0.15F},
    {"torso/torso-scale-vert", 0.15F, 0.15F},
    {"stomach/stomach-pregnant", 0.15F, 0.15F},
    {"buttocks/buttocks-volume", 0.20F, 0.20F, 0.00F, 0.00F},
    {"armslegs/upperleg-fat", 0.20F, 0.20F, 0, 0, true},
    {"armslegs/upperarm-fat", 0.20F, 0.20F, 0, 0, true},
    {"armslegs/lowerleg-muscle", 0.25F, 0.25F, 0, 0, true},
    // Training alone.
    {"torso/torso-scale-depth", 0.20F, 0},
    {"torso/torso-trans-vert", 0.20F, 0},
    {"hip/hip-trans-vert", 0.20F, 0},
    {"measure/measure-frontchest-dist", 0.20F, 0},
    {"measure/measure-napetowaist-dist", 0.25F, 0},
    {"measure/measure-waisttohip-dist", 0.20F, 0},
    {"head/head-scale-horiz", 0.25F, 0},
    {"head/head-scale-vert", 0.20F, 0},
    {"head/head-fat", 0.25F, 0},
    {"armslegs/upperarm-muscle", 0.25F, 0, 0, 0, true},
    {"armslegs/upperleg-muscle", 0.25F, 0, 0, 0, true},
    // Held out.
    {"torso/torso-vshape", 0, 0.30F},
    {"torso/torso-trans-depth", 0, 0.25F},
    {"torso/torso-muscle-dorsi", 0, 0.35F},
    {"torso/torso-muscle-pectoral", 0, 0.35F},
    {"hip/hip-waist", 0, 0.35F},
    {"hip/hip-trans-depth", 0, 0.25F},
    {"hip/hip-scale-vert", 0, 0.25F},
    {"stomach/stomach-tone", 0, 0.40F},
    {"stomach/stomach-navel-vert", 0, 0.40F},
    {"stomach/stomach-navel-depth", 0, 0.40F},
    {"pelvis/pelvis-tone", 0, 0.40F},
    {"neck/neck-scale-horiz", 0, 0.20F},
    {"neck/neck-scale-depth", 0, 0.20F},
    {"neck/neck-back-scale-depth", 0, 0.30F},
    {"breast/breast-trans-vert", 0, 0.30F},
    {"breast/breast-dist", 0, 0.30F},
    {"breast/breast-volume-vert", 0, 0.30F},
    {"head/head-oval", 0, 0.30F},
    {"head/head-square", 0, 0.30F},
    {"head/head-scale-depth", 0, 0.25F},
    {"armslegs/upperleg-scale-horiz", 0, 0.25F, 0, 0, true},
    {"armslegs/upperarm-scale-depth", 0, 0.25F, 0, 0, true},
    {"armslegs/lowerleg-fat", 0, 0.25F, 0, 0, true},
    {"asym/asymm-trunk-1", 0, 0.35F},
};
constexpr double kDrawLimit = 2.2;       // standard deviations
constexpr float kAsymmetryShare = 0.3F;  // of a paired modifier's spread, each side

std::string with_side(std::string_view name, char side) {
  const std::size_t slash = name.find('/') + 1;
  return std::string(name.substr(0, slash)) + side + "-" + std::string(name.substr(slash));
}

}  // namespace

std::span<const ModifierSpread> modifier_spreads() {
  return kSpreads;
}

std::vector<float> draw_modifiers(const BodyModel& model, SpreadUse use, bool woman, Rng& rng) {
  std::vector<float> values(model.modifier_names().size());
  const auto add = [&](std::string_view name, float value) {
    const int index = model.modifier_index(name);
    if (index >= 0) values[static_cast<std::size_t>(index)] += std::clamp(value, -1.0F, 1.0F);
  };
  for (const ModifierSpread& row : kSpreads) {
    const float common = static_cast<float>(std::clamp(rng.normal(), -kDrawLimit, kDrawLimit));
    const float apart = static_cast<float>(std::clamp(rng.normal(), -kDrawLimit, kDrawLimit));
    const float sd = use == SpreadUse::training ? row.training_sd : row.held_out_sd;
    const float mean = woman ? row.woman_mean : row.man_mean;
    if (sd == 0) continue;
    if (row.paired && use == SpreadUse::held_out) {
      const float difference = kAsymmetryShare * sd * apart;
      add(with_side(row.name, 'l'), mean + sd * common + difference);
      add(with_side(row.name, 'r'), mean + sd * common - difference);
    } else {
      add(row.name, mean + sd * common);
    }
  }
  return values;
}

}  // namespace im2fit::body
