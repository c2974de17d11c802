// SPDX-License-Identifier: Apache-2.0
// im2fit-wardrobe-table data > engine/builtin_wardrobe.inc
#include <cstdio>
#include <string_view>

#include "engine/report/garment_file.h"

int main(int argc, char** argv) {
  if (argc != 2 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "im2fit-wardrobe-table data > engine/builtin_wardrobe.inc\n");
    return 2;
  }
  const auto wardrobe = im2fit::read_shipped_wardrobe(argv[1]);
  if (!wardrobe) {
    std::fprintf(stderr, "im2fit-wardrobe-table: %s\n", wardrobe.error().message.c_str());
    return 1;
  }
  std::fputs(im2fit::wardrobe_table(*wardrobe).c_str(), stdout);
  return 0;
}
