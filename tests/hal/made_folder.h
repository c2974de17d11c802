// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "core/file.h"
#include "hal/folder/depth_folder.h"
#include "support.h"

namespace im2fit::hal {

constexpr int kMadeWidth = 48;
constexpr int kMadeHeight = 40;

inline void put(const std::string& path, const std::string& text) {
  ASSERT_TRUE(write_file_atomically(path, text));
}

// A good folder of `count` frames; a test then spoils one thing.
inline void make_folder(const std::string& path, DepthFormat format = DepthFormat::png, std::uint64_t count = 4) {
  FolderWriter::Options options;
  options.format = format;
  auto writer = FolderWriter::create(path, camera_of(kMadeWidth, kMadeHeight), options);
  ASSERT_TRUE(writer) << writer.error().message;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto time = static_cast<std::int64_t>(1000 + i);
    ASSERT_TRUE((*writer)->write(random_picture(kMadeWidth, kMadeHeight, i).view(), FrameInfo{i, time * 1000, time}));
  }
  ASSERT_TRUE((*writer)->finish());
}

}  // namespace im2fit::hal
