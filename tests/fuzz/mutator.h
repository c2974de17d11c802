// SPDX-License-Identifier: Apache-2.0
// For libFuzzer: half of the mutants get right checksums, else none would pass the first check.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "tests/fuzz/damage.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t size_max);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t size_max,
                                               unsigned int seed) {
  size = LLVMFuzzerMutate(data, size, size_max);
  if (seed % 2 == 0) return size;
  im2fit::fuzz::Bytes bytes(size);
  std::memcpy(bytes.data(), data, size);
  im2fit::fuzz::mend_checksums(bytes);
  std::memcpy(data, bytes.data(), size);
  return size;
}
