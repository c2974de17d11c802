// SPDX-License-Identifier: Apache-2.0
// im2fit-lab make wardrobe-table data > person/builtin_wardrobe.inc
#include <cstdio>
#include <string_view>

#include "apps/im2fit-lab/make/make.h"
#include "person/garment_file.h"

namespace im2fit::apps {

int make_wardrobe_table(int argc, char** argv) {
  if (argc != 2 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "im2fit-lab make wardrobe-table data > person/builtin_wardrobe.inc\n");
    return 2;
  }
  const auto wardrobe = im2fit::read_shipped_wardrobe(argv[1]);
  if (!wardrobe) {
    std::fprintf(stderr, "im2fit-lab make wardrobe-table: %s\n", wardrobe.error().message.c_str());
    return 1;
  }
  std::fputs(im2fit::wardrobe_table(*wardrobe).c_str(), stdout);
  return 0;
}

}  // namespace im2fit::apps
