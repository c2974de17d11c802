// SPDX-License-Identifier: Apache-2.0
#include "train/population/drape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace im2fit::lab {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

std::size_t wrapped(int sector, int count) {
  return static_cast<std::size_t>((sector % count + count) % count);
}

}  // namespace

Folds::Folds(Rng& rng, double shortest, double longest, Vec3f grain, float stretch) {
  for (Wave& w : waves_) {
    const auto x = static_cast<float>(rng.normal()), y = static_cast<float>(rng.normal()),
               z = static_cast<float>(rng.normal());
    const Vec3f k = Vec3f{x, y, z} - grain * (dot(Vec3f{x, y, z}, grain) * (1 - 1 / stretch));
    w.k = normalized(k) * (kTurn / static_cast<float>(rng.uniform(shortest, longest)));
    w.phase = static_cast<float>(rng.uniform(0, 2 * std::numbers::pi));
  }
}

float Folds::at(Vec3f p) const {
  float sum = 0;
  for (const Wave& w : waves_) sum += std::sin(dot(w.k, p) + w.phase);
  return sum / std::sqrt(static_cast<float>(waves_.size()));
}

void TrunkHang::add(float up, float angle, float radius_mm) {
  const auto level = static_cast<int>(std::floor(level_of(up)));
  if (level < 0 || level >= kLevels) return;
  const auto sector = static_cast<int>(std::floor(angle / kTurn * kSectors));
  // Vertices are up to a cell apart.
  for (int l = std::max(0, level - 1); l <= std::min(kLevels - 1, level + 1); ++l) {
    for (int s = -1; s <= 1; ++s) {
      float& most = radius_[static_cast<std::size_t>(l)][wrapped(sector + s, kSectors)];
      most = std::max(most, radius_mm);
    }
  }
}

void TrunkHang::hang(float chest, float slack_mm) {
  for (Ring& ring : radius_) {
    // The chord between two points d sectors to either side, seen from the axis.
    const Ring own = ring;
    for (int s = 0; s < kSectors; ++s) {
      float& r = ring[static_cast<std::size_t>(s)];
      for (int d = 1; d <= 6; ++d) {
        const float chord = std::min(own[wrapped(s - d, kSectors)], own[wrapped(s + d, kSectors)]) *
                            std::cos(kTurn * static_cast<float>(d) / kSectors);
        r = std::max(r, chord);
      }
    }
  }
  for (int l = std::min(kLevels - 2, static_cast<int>(level_of(chest))); l >= 0; --l) {
    const auto at = static_cast<std::size_t>(l);
    for (std::size_t s = 0; s < kSectors; ++s)
      radius_[at][s] = std::max(radius_[at][s], radius_[at + 1][s] - slack_mm);
  }
}

float TrunkHang::at(float up, float angle) const {
  const float level = std::clamp(level_of(up) - 0.5F, 0.0F, static_cast<float>(kLevels) - 1.001F);
  const float sector = angle / kTurn * kSectors - 0.5F;
  const auto l = static_cast<std::size_t>(level);
  const auto s = static_cast<int>(std::floor(sector));
  const float y = level - static_cast<float>(l), x = sector - static_cast<float>(s);
  const std::size_t left = wrapped(s, kSectors), right = wrapped(s + 1, kSectors);
  return (1 - y) * ((1 - x) * radius_[l][left] + x * radius_[l][right]) +
         y * ((1 - x) * radius_[l + 1][left] + x * radius_[l + 1][right]);
}

}  // namespace im2fit::lab
