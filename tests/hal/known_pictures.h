// SPDX-License-Identifier: Apache-2.0
// Folders of known pictures, and our virtual OpenNI2 device that shows them.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "hal/folder/depth_folder.h"
#include "hal/openni2/openni2_source.h"
#include "support.h"
#include "tests/devices/process_state.h"

namespace im2fit::hal {

constexpr int kWidth = 320;  // other rigs have others
constexpr int kHeight = 240;
inline constexpr int kLimit = 32768;
inline constexpr int kPictures = 30;

inline Intrinsics centred(int width, int height) {
  return {
      width, height, 287.9F, 287.31F, 0.5F * static_cast<float>(width - 1), 0.5F * static_cast<float>(height - 1)};
}

// Picture `index` of the known folder; its first pixel is its number.
inline Picture known(int index) {
  Picture picture = random_picture(kWidth, kHeight, 1000 + static_cast<std::uint64_t>(index), kLimit);
  picture.pixels.front() = static_cast<std::uint16_t>(index + 1);
  return picture;
}

inline void make_known_folder(const std::string& path) {
  FolderWriter::Options options;
  options.format = DepthFormat::pgm;
  auto writer = FolderWriter::create(path, centred(kWidth, kHeight), options);
  ASSERT_TRUE(writer) << writer.error().message;
  for (int i = 0; i < kPictures; ++i)
    ASSERT_TRUE((*writer)->write(known(i).view(), FrameInfo{static_cast<std::uint64_t>(i), i + 1, -1}));
}

inline std::string virtual_uri(const std::string& folder, const std::string& more = "") {
  static int number = 0;  // the runtime does not forget a URI that was unplugged: each test has its own
  return "im2fit-virtual://" + std::to_string(++number) + "?folder=" + folder + more;
}

inline bool have_virtual_device() {
  static const bool there = [] {
    const TestFolder folder;
    make_known_folder(folder.path("known"));
    auto source = OpenNi2Source::open(virtual_uri(folder.path("known")), {});
    if (!source) std::fprintf(stderr, "%s\n", source.error().message.c_str());
    return static_cast<bool>(source);
  }();
  return there;
}

#define NEED_VIRTUAL_DEVICE() \
  if (!have_virtual_device()) GTEST_SKIP() << "no virtual OpenNI2 device: build the target im2fit_virtual"

using devices::open_files;

}  // namespace im2fit::hal
