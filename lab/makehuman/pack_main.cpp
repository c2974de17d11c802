// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>

#include "core/file.h"
#include "lab/makehuman/makehuman.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: im2fit-pack-body MAKEHUMAN_DIR OUT.i2b\n");
    return 2;
  }
  const auto bytes = im2fit::body::pack_makehuman(argv[1]);
  if (!bytes) {
    std::fprintf(stderr, "im2fit-pack-body: %s\n", bytes.error().message.c_str());
    return 1;
  }
  const auto parent = std::filesystem::path(argv[2]).parent_path().string();
  if (!parent.empty())
    if (const auto made = im2fit::make_directory(parent); !made) {
      std::fprintf(stderr, "im2fit-pack-body: %s\n", made.error().message.c_str());
      return 1;
    }
  if (const auto written = im2fit::write_file_atomically(argv[2], *bytes); !written) {
    std::fprintf(stderr, "im2fit-pack-body: %s\n", written.error().message.c_str());
    return 1;
  }
  return 0;
}
