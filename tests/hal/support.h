// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/rng.h"
#include "hal/intrinsics.h"

namespace im2fit::hal {

// A folder of the test's own, removed with it.
class TestFolder {
 public:
  TestFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "im2fit-hal-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TestFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string path(const std::string& name = "") const { return name.empty() ? path_ : path_ + "/" + name; }

 private:
  std::string path_;
};

struct Picture {
  std::vector<std::uint16_t> pixels;
  int width = 0;
  int height = 0;
  Picture(int w, int h) : pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)), width(w), height(h) {}
  DepthImage image() { return {pixels.data(), width, height}; }
  DepthView view() const { return {pixels.data(), width, height}; }
};

// Random depths below `limit`, a quarter of them 0, runs and noise mixed as depth codecs see them.
inline Picture random_picture(int width, int height, std::uint64_t seed, int limit = 65536) {
  Picture picture(width, height);
  Rng rng(seed);
  int value = 0;
  for (auto& pixel : picture.pixels) {
    const int kind = rng.index(8);
    if (kind < 2)
      value = 0;
    else if (kind < 4)
      value = rng.index(limit);
    else if (kind < 6)
      value = std::min(limit - 1, value + rng.index(3));
    pixel = static_cast<std::uint16_t>(value);
  }
  picture.pixels.back() = static_cast<std::uint16_t>(limit - 1);
  return picture;
}

inline Intrinsics camera_of(int width, int height) {
  const float f = 0.9F * static_cast<float>(width);
  return {width,
          height,
          f,
          f * 1.01F,
          0.5F * static_cast<float>(width) - 3.25F,
          0.5F * static_cast<float>(height) + 1.125F};
}

inline std::string yaml_of(const Intrinsics& k, const std::string& name, int rotate_deg) {
  return camera_yaml_text(Calibration{k, {}, rotate_deg, IntrinsicsOrigin::calibration_file}, name);
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace im2fit::hal
