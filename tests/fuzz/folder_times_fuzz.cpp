// SPDX-License-Identifier: Apache-2.0
// timestamps.csv as anyone may have written it: refused with one line, or times that grow.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/file.h"
#include "hal/folder/depth_folder.h"

namespace {

// Three frames of 2 x 2 pixels, in memory. Its name outlives every destructor: the end removes the folder by it.
const std::string& folder() {
  static const std::string& path = *new std::string([] {
    std::string name = "/dev/shm/im2fit-fuzz-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    std::atexit([] { std::filesystem::remove_all(folder()); });
    const im2fit::Intrinsics k{2, 2, 2, 2, 0.5F, 0.5F};
    auto writer = im2fit::hal::FolderWriter::create(name, k, {});
    std::uint16_t pixels[4] = {1000, 1001, 1002, 1003};
    for (std::uint64_t i = 0; i < 3; ++i)
      if (!writer || !(*writer)->write(im2fit::DepthView(pixels, 2, 2), {i, static_cast<std::int64_t>(i) + 1, -1}))
        std::abort();
    return name;
  }());
  return path;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  if (!write_file_atomically(folder() + "/timestamps.csv", std::as_bytes(std::span(data, size)))) std::abort();
  auto source = hal::FolderSource::open(folder());
  if (!source) {
    if (source.error().message.empty() || source.error().message.find('\n') != std::string::npos) __builtin_trap();
    return 0;
  }
  std::uint16_t pixels[4];
  std::int64_t last_ns = -1;
  for (int i = 0; i < 3; ++i) {
    const auto info = (*source)->next(DepthImage(pixels, 2, 2), 0);
    if (!info || info->host_ns <= last_ns) __builtin_trap();
    last_ns = info->host_ns;
  }
  return 0;
}
