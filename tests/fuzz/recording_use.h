// SPDX-License-Identifier: Apache-2.0
// What fuzzers of recordings ask of a reader: errors of one line, and an end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/source.h"

namespace im2fit::fuzz {

inline void check_one_line(const Error& error) {
  if (error.message.empty() || error.message.find('\n') != std::string::npos) __builtin_trap();
}

// Reads frames until the source ends. False: it did not end within this many calls.
inline bool read_to_end(hal::Source& source, std::size_t calls_max) {
  const Intrinsics k = source.info().intrinsics;
  std::vector<std::uint16_t> picture(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  for (std::size_t calls = 0; calls <= calls_max; ++calls) {
    const auto frame = source.next({picture.data(), k.width, k.height}, 0);
    if (frame) continue;
    check_one_line(frame.error());
    if (frame.error().code == ErrorCode::end_of_stream) return true;
  }
  return false;
}

}  // namespace im2fit::fuzz
