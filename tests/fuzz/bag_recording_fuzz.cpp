// SPDX-License-Identifier: Apache-2.0
// Rosbags as anyone may have written them: refused in one line, or frames, each read or one line, up to an end.
#include <cstdint>
#include <span>

#include "hal/recording/bag_recording.h"
#include "recording_use.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  auto source = hal::open_bag_recording(hal::FileCursor(std::as_bytes(std::span(data, size)), "a recording"), {});
  if (!source) return fuzz::check_one_line(source.error()), 0;
  // A message has 40 bytes or more, but a compressed chunk may repeat it more often than this.
  constexpr std::size_t kCallsMax = 100'000;
  fuzz::read_to_end(**source, kCallsMax);
  return 0;
}
