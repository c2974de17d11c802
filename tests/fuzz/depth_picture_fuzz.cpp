// SPDX-License-Identifier: Apache-2.0
// A PNG or PGM of a depth folder: refused with one line, or a picture, in bounded time.
#include <cstdint>
#include <string>
#include <vector>

#include "hal/depth_diagnosis.h"
#include "hal/folder/depth_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto header = hal::parse_depth_header(bytes, "picture");
  if (!header) {
    if (header.error().message.empty() || header.error().message.find('\n') != std::string::npos) __builtin_trap();
    return 0;
  }
  if (header->width > 256 || header->height > 256) return 0;  // larger ones take the same path, slower
  std::vector<std::uint16_t> out(static_cast<std::size_t>(header->width) * static_cast<std::size_t>(header->height));
  const DepthImage image(out.data(), header->width, header->height);
  if (!hal::decode_depth(bytes, "picture", image)) return 0;
  const std::string diagnosis = hal::depth_diagnosis(DepthView(out.data(), header->width, header->height)).text;
  if (diagnosis.find('\n') != std::string::npos) __builtin_trap();
  return 0;
}
