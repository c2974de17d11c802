// SPDX-License-Identifier: Apache-2.0
// Workstation side: millions of entries from tens of thousands of real ones, to measure speed and size on. No person
// was rendered for them: results that rest on them must state it.
//
// A densified entry mixes two real captures i and j of one sex: value = mean + cos(a) (value_i - mean) +
// sin(a) (value_j - mean), a uniform in 15..75 degrees, mean that sex's. Means and covariances of features, errors
// and truths within a sex stay what they are, for Gaussian populations also the distribution, and no two entries are
// alike. Since every step from a feature to its place is linear, places and truths are mixed, not features.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace im2fit::index {

struct Mix {
  std::uint32_t first = 0, second = 0;  // real entries; the first, the heavier, lends its number and age
  double first_share = 1, second_share = 0;
};

// `of_sex`: the real entries' numbers by sex; a sex with fewer than two is left out. At least one has two. The mix of
// the n-th densified entry depends on its number and the seed only.
class Densifier {
 public:
  Densifier(std::array<std::vector<std::uint32_t>, 2> of_sex, std::uint64_t seed);
  Mix mix(std::uint64_t n) const;

 private:
  std::array<std::vector<std::uint32_t>, 2> of_sex_;
  std::uint64_t seed_;
};

}  // namespace im2fit::index
