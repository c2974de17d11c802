// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>

#include "kernels/sample/sample.h"

namespace im2fit {
namespace {

constexpr std::uint16_t kNone = 65535;

// Depth less one: no data, be it 0 or too far, sorts last, and one added to "none" gives 0 again.
std::uint16_t sort_key(std::uint16_t z) {
  const auto less = static_cast<std::uint16_t>(z - 1);
  return less < kSampleDepthMaxMm ? less : kNone;
}

void order(std::uint16_t& a, std::uint16_t& b) {
  const std::uint16_t low = std::min(a, b);
  b = std::max(a, b);
  a = low;
}

// Sorted, the fifth is there only when all five are and the third only when three are: that says which is the median.
std::uint16_t median(std::uint16_t a, std::uint16_t b, std::uint16_t c, std::uint16_t d, std::uint16_t e) {
  order(a, b);
  order(d, e);
  order(c, e);
  order(c, d);
  order(a, d);
  order(a, c);
  order(b, e);
  order(b, d);
  order(b, c);
  const std::uint16_t fewer = c == kNone ? a : b;
  return static_cast<std::uint16_t>((e == kNone ? fewer : c) + 1);
}

}  // namespace

void sample_portable(DepthView depth, int step, std::uint16_t* out) {
  const int last = step - 1;
  const int width = depth.width / step;
  for (int r = 0; r < depth.height / step; ++r) {
    const std::uint16_t* top = depth.row(r * step);
    const std::uint16_t* middle = depth.row(r * step + step / 2) + step / 2;
    const std::uint16_t* bottom = depth.row(r * step + last);
    for (int c = 0; c < width; ++c) {
      const std::ptrdiff_t u = std::ptrdiff_t{c} * step;
      out[c] = median(sort_key(top[u]), sort_key(top[u + last]), sort_key(middle[u]), sort_key(bottom[u]),
                      sort_key(bottom[u + last]));
    }
    out += width;
  }
}

void sample(DepthView depth, int step, std::uint16_t* out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kSampleKernels);
  best(depth, step, out);
}

}  // namespace im2fit
