// SPDX-License-Identifier: Apache-2.0
// Recordings of an Azure Kinect as anyone may have written them: refused in one line, or frames, each read or one
// line, up to an end.
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "hal/recording/kinect_recording.h"

namespace {

void check(const im2fit::Error& error) {
  if (error.message.empty() || error.message.find('\n') != std::string::npos) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  auto source = hal::open_kinect_recording(hal::FileCursor(std::as_bytes(std::span(data, size)), "a recording"), {});
  if (!source) return check(source.error()), 0;
  const Intrinsics k = (*source)->info().intrinsics;
  std::vector<std::uint16_t> picture(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  // A frame has a byte or more.
  for (std::size_t calls = 0;; ++calls) {
    if (calls > size) __builtin_trap();
    const auto frame = (*source)->next({picture.data(), k.width, k.height}, 0);
    if (frame) continue;
    check(frame.error());
    if (frame.error().code == ErrorCode::end_of_stream) return 0;
  }
}
