// SPDX-License-Identifier: Apache-2.0
// The bit stream of structured-light cameras (Kinect for Xbox 360, PrimeSense) to one number a pixel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/tier.h"

namespace im2fit {

// `count` values of 11 bits, the most significant bit first and no gaps between them, so that 8 values are 11 bytes.
// `packed` has unpack11_bytes(count) bytes and none beyond them is read; bits after the last value are ignored.
// `out` has `count` values of 0 to 2047. No allocation, thread-safe. All tiers agree bit for bit.
using Unpack11Function = void(const std::uint8_t* packed, int count, std::uint16_t* out);
Unpack11Function unpack11_portable, unpack11_neon, unpack11_avx2;
Unpack11Function unpack11;  // the fastest here

constexpr std::size_t unpack11_bytes(int count) {
  return (static_cast<std::size_t>(count) * 11 + 7) / 8;
}

using Unpack11Kernel = KernelVariant<Unpack11Function>;
inline constexpr Unpack11Kernel kUnpack11Kernels[] = {IM2FIT_PORTABLE(unpack11) IM2FIT_NEON(unpack11)
                                                          IM2FIT_AVX2(unpack11)};

}  // namespace im2fit
