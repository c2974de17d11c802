// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {

void unpack11_ref(const std::uint8_t* packed, int count, std::uint16_t* out) {
  std::size_t bit = 0;
  for (int i = 0; i < count; ++i) {
    int value = 0;
    for (int k = 0; k < 11; ++k, ++bit) value = 2 * value + ((packed[bit / 8] >> (7 - bit % 8)) & 1);
    out[i] = static_cast<std::uint16_t>(value);
  }
}

}  // namespace im2fit
