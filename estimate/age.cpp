// SPDX-License-Identifier: Apache-2.0
#include "estimate/age.h"

#include <algorithm>

namespace im2fit {
namespace {

constexpr std::array<float, kAgeBandCount - 1> kBandEnds = {25, 45, 65};

// Between the two sorted values it falls between.
float quantile(std::span<const float> sorted, float share) {
  const float place = share * static_cast<float>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<float>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

std::size_t age_band_of(float years) {
  return static_cast<std::size_t>(std::upper_bound(kBandEnds.begin(), kBandEnds.end(), years) - kBandEnds.begin());
}

AgeAnswer age_among(std::span<float> ages) {
  AgeAnswer answer;
  if (ages.empty()) return answer;
  std::sort(ages.begin(), ages.end());
  answer.years = {quantile(ages, 0.5F), quantile(ages, 0.025F), quantile(ages, 0.975F)};
  for (const float age : ages) answer.bands[age_band_of(age)] += 1.0F / static_cast<float>(ages.size());
  return answer;
}

}  // namespace im2fit
