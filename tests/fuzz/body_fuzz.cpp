// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/body_use.h"
#include "tests/fuzz/mutator.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  if (const auto sane = im2fit::fuzz::use_body({bytes, bytes + size}); sane && !*sane) __builtin_trap();
  return 0;
}
