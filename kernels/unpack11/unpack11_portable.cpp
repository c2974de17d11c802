// SPDX-License-Identifier: Apache-2.0
#include "kernels/unpack11/unpack11.h"

namespace im2fit {
namespace {

// Compilers know this as one load and one byte swap.
std::uint64_t big_endian(const std::uint8_t* p) {
  return std::uint64_t{p[0]} << 56 | std::uint64_t{p[1]} << 48 | std::uint64_t{p[2]} << 40 |
         std::uint64_t{p[3]} << 32 | std::uint64_t{p[4]} << 24 | std::uint64_t{p[5]} << 16 |
         std::uint64_t{p[6]} << 8 | std::uint64_t{p[7]};
}

std::uint16_t low11(std::uint64_t bits) {
  return static_cast<std::uint16_t>(bits & 0x7FF);
}

}  // namespace

void unpack11_portable(const std::uint8_t* packed, int count, std::uint16_t* out) {
  int i = 0;
  // Bits 0 to 63 of a group's 88 hold values 0 to 4, bits 24 to 87 end with values 5 to 7.
  for (; i + 8 <= count; i += 8, packed += 11, out += 8) {
    const std::uint64_t first = big_endian(packed), last = big_endian(packed + 3);
    out[0] = low11(first >> 53);
    out[1] = low11(first >> 42);
    out[2] = low11(first >> 31);
    out[3] = low11(first >> 20);
    out[4] = low11(first >> 9);
    out[5] = low11(last >> 22);
    out[6] = low11(last >> 11);
    out[7] = low11(last);
  }
  std::uint32_t bits = 0;
  int held = 0;
  for (; i < count; ++i) {
    for (; held < 11; held += 8) bits = bits << 8 | *packed++;
    held -= 11;
    *out++ = low11(bits >> held);
  }
}

void unpack11(const std::uint8_t* packed, int count, std::uint16_t* out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kUnpack11Kernels);
  best(packed, count, out);
}

}  // namespace im2fit
