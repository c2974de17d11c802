// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/index_use.h"
#include "tests/fuzz/mutator.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  const auto found = im2fit::fuzz::use_index({bytes, bytes + size});
  if (found && !found->sane) __builtin_trap();
  return 0;
}
