// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

std::uint32_t geodesic_ref(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z, int count) {
  double length = 0;
  for (int i = 1; i < count; ++i) {
    const auto part = [i](const std::int32_t* a) {
      return std::fmin(std::fmax(double{1} * a[i] - a[i - 1], -32768), 32767);
    };
    length += std::sqrt(part(x) * part(x) + part(y) * part(y) + part(z) * part(z));
  }
  return static_cast<std::uint32_t>(std::llround(length));
}

}  // namespace im2fit
