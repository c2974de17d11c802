// SPDX-License-Identifier: Apache-2.0
// Tables compiled into the library.
//   im2fit-lab make tape-table data/tape > person/builtin_tape.inc
//   im2fit-lab make wardrobe-table data > person/builtin_wardrobe.inc
#include <cstdio>
#include <string_view>

#include "apps/im2fit-lab/make/make.h"
#include "person/garment_file.h"
#include "person/tape_file.h"

namespace im2fit::apps {

int make_tape_table(int argc, char** argv) {
  if (argc != 2 || std::string_view(argv[1]) == "--help") {
    std::fprintf(stderr, "im2fit-lab make tape-table data/tape > person/builtin_tape.inc\n");
    return 2;
  }
  const auto tape = im2fit::read_shipped_tape(argv[1]);
  const auto text = tape ? im2fit::tape_table(*tape) : im2fit::Result<std::string>(tape.error());
  if (!text) {
    std::fprintf(stderr, "im2fit-lab make tape-table: %s\n", text.error().message.c_str());
    return 1;
  }
  std::fputs(text->c_str(), stdout);
  return 0;
}

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
