// SPDX-License-Identifier: Apache-2.0
// Recordings of an Azure Kinect as anyone may have written them: refused in one line, or frames, each read or one
// line, up to an end.
#include <cstdint>
#include <span>

#include "hal/recording/kinect_recording.h"
#include "recording_use.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  auto source = hal::open_kinect_recording(hal::FileCursor(std::as_bytes(std::span(data, size)), "a recording"), {});
  if (!source) return fuzz::check_one_line(source.error()), 0;
  // A frame has a byte or more.
  if (!fuzz::read_to_end(**source, size)) __builtin_trap();
  return 0;
}
