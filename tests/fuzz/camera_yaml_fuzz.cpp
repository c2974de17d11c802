// SPDX-License-Identifier: Apache-2.0
// A calibration as a user or a camera's maker may have written it: refused with one line, or one that a picture can
// be made upright with.
#include <cmath>
#include <cstdint>
#include <string>

#include "hal/folder/camera_yaml.h"
#include "hal/frame_path.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto file = im2fit::hal::parse_camera_yaml(text, "camera.yaml", {32, 24});
  if (!file) {
    if (file.error().message.empty() || file.error().message.find('\n') != std::string::npos) __builtin_trap();
    return 0;
  }
  const im2fit::Intrinsics& k = file->intrinsics;
  if (!(k.width >= 1 && k.width <= 2048 && k.height >= 1 && k.height <= 2048 && k.fx > 0 && k.fy > 0 &&
        std::isfinite(k.fx) && std::isfinite(k.fy) && std::isfinite(k.cx) && std::isfinite(k.cy)))
    __builtin_trap();
  if (k.width * k.height > 64 * 48) return 0;  // larger ones take the same path, slower
  auto path = im2fit::hal::UprightPath::make(*file, file->rotate_deg.value_or(0), "camera.yaml");
  if (!path) return 0;
  std::vector<std::uint16_t> out(path->pixel_count());
  path->deliver(im2fit::DepthImage(out.data(), path->upright().width, path->upright().height));
  return 0;
}
