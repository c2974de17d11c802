// SPDX-License-Identifier: Apache-2.0
#include "train/index/densify.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/rng.h"

namespace im2fit::index {

Densifier::Densifier(std::array<std::vector<std::uint32_t>, 2> of_sex, std::uint64_t seed)
    : of_sex_(std::move(of_sex)), seed_(seed) {}

Mix Densifier::mix(std::uint64_t n) const {
  Rng rng = Rng::for_item(seed_, 0xD0B1E, n);
  std::size_t sex = n % 2;
  if (of_sex_[sex].size() < 2) sex = 1 - sex;
  const auto& members = of_sex_[sex];
  const int count = static_cast<int>(members.size());
  const int first = rng.index(count);
  const int second = (first + 1 + rng.index(count - 1)) % count;
  const double angle = rng.uniform(std::numbers::pi / 12, 5 * std::numbers::pi / 12);
  Mix mix{members[static_cast<std::size_t>(first)], members[static_cast<std::size_t>(second)], std::cos(angle),
          std::sin(angle)};
  if (mix.first_share < mix.second_share) {
    std::swap(mix.first, mix.second);
    std::swap(mix.first_share, mix.second_share);
  }
  return mix;
}

}  // namespace im2fit::index
