// SPDX-License-Identifier: Apache-2.0
// What a reader of a hostile recording may send its parent: frames of the size it announced, or one error, and an
// end.
#include <fcntl.h>
#include <unistd.h>

#include <cstdint>
#include <vector>

#include "hal/openni2/oni_reader.h"
#include "hal/openni2/oni_source.h"

// The reader itself needs OpenNI2; here its words are the fuzzer's.
int im2fit::hal::serve_oni(const std::string&, int) {
  __builtin_trap();
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) __builtin_trap();
  ::fcntl(ends[1], F_SETPIPE_SZ, 1 << 20);
  ::fcntl(ends[1], F_SETFL, O_NONBLOCK);
  [[maybe_unused]] const auto written = ::write(ends[1], data, size);
  ::close(ends[1]);
  hal::OniOptions options;
  options.stall_ms = 1000;
  options.reader = [&]() -> Result<hal::ChildProcess> { return hal::ChildProcess::reading(ends[0]); };
  const auto source = hal::OniSource::open("/proc/self/exe", options);
  if (!source) {
    if (source.error().message.find('\n') != std::string::npos) __builtin_trap();
    return 0;
  }
  const Intrinsics& k = (*source)->info().intrinsics;
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  const DepthImage depth(pixels.data(), k.width, k.height);
  std::size_t frames = 0;
  for (;;) {
    const auto frame = (*source)->next(depth, 0);
    if (!frame) {
      if (frame.error().message.find('\n') != std::string::npos) __builtin_trap();
      if (frame.error().code == ErrorCode::end_of_stream || frame.error().code == ErrorCode::io) break;
      continue;
    }
    if (++frames * 32 > size || frame->host_ns < 0) __builtin_trap();  // a frame is at least so many bytes
  }
  // It stays as it ended.
  if ((*source)->next(depth, 0)) __builtin_trap();
  return 0;
}
