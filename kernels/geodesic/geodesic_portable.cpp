// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "kernels/geodesic/geodesic.h"

namespace im2fit {
namespace {

std::int32_t part(std::int32_t to, std::int32_t from) {
  const std::int32_t step = to - from;
  return step > INT16_MAX ? INT16_MAX : step < INT16_MIN ? INT16_MIN : step;
}

// The double root of a 32-bit number, unless whole, is 2^-17 or more from whole numbers: cutting it off is exact.
std::uint32_t nearest_root(std::uint32_t square) {
  const auto root = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(square)));
  return square - root * root > root ? root + 1 : root;
}

}  // namespace

std::uint32_t geodesic_portable(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z, int count) {
  std::uint32_t length = 0;
  for (int i = 1; i < count; ++i) {
    const std::int32_t dx = part(x[i], x[i - 1]), dy = part(y[i], y[i - 1]), dz = part(z[i], z[i - 1]);
    length += nearest_root(static_cast<std::uint32_t>(dx * dx) + static_cast<std::uint32_t>(dy * dy) +
                           static_cast<std::uint32_t>(dz * dz));
  }
  return length;
}

std::uint32_t geodesic(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z, int count) {
  return geodesic_portable(x, y, z, count);
}

}  // namespace im2fit
