// SPDX-License-Identifier: Apache-2.0
// ANSUR II split in two: one part may teach (densities and laws that training people are drawn from), the other only
// judges (the evaluation's family `ansur`). Decided by the row alone, so that neither side depends on what the other
// reads or in which order.
#pragma once

#include <cstddef>
#include <cstdint>

namespace im2fit::lab {

// `row`: 0-based place in what read_ansur_columns() returns for that sex. True: only the evaluation may use it.
constexpr bool held_out_row(bool woman, std::size_t row) {
  std::uint64_t z = (static_cast<std::uint64_t>(row) * 2 + (woman ? 1 : 0)) * 0x9E3779B97F4A7C15ULL + 0xA45A;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;  // SplitMix64's finaliser: neighbours in the file are unrelated
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return ((z ^ (z >> 31)) & 1) != 0;
}

}  // namespace im2fit::lab
