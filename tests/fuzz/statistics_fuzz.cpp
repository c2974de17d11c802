// SPDX-License-Identifier: Apache-2.0
// A file of counts as anyone may write it: refused with one line, or counts that are written as they are read.
#include <cstdint>
#include <string>

#include "apps/kiosk/statistics.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto counts = apps::Statistics::parse(text, "counts.csv");
  if (!counts) {
    if (counts.error().message.empty() || counts.error().message.find('\n') != std::string::npos) __builtin_trap();
    return 0;
  }
  const std::string csv = (*counts)->csv();
  const auto again = apps::Statistics::parse(csv, "again");
  if (!again || (*again)->csv() != csv) __builtin_trap();
  // Counting goes on, with whatever a chart names its sizes.
  (*counts)->visit("2026-11-30");
  (*counts)->measured("2026-11-30", text);
  (*counts)->not_measured("2026-11-30", "MOVING");
  if (!apps::Statistics::parse((*counts)->csv(), "more")) __builtin_trap();
  return 0;
}
