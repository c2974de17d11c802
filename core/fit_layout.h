// SPDX-License-Identifier: Apache-2.0
// The numbers and kinds of the values that describe a fitted shape (body/fit); indexes learn from them (index).
#pragma once

#include <cstddef>
#include <cstdint>

namespace im2fit {

// Coefficients of the shape, then how far off each patch of the skin is, of the front and of the back, then how the
// limbs lie in either view. NaN: not seen, or a fit to the front alone.
struct FitLayout {
  std::uint32_t shapes = 0;
  std::uint32_t patches = 0;  // of a view
  std::uint32_t limbs = 0;    // values of a view
  std::size_t size() const { return shapes + 2 * (std::size_t{patches} + limbs); }
  bool operator==(const FitLayout&) const = default;
};

}  // namespace im2fit
