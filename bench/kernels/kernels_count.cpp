// SPDX-License-Identifier: Apache-2.0
// Runs one case a given number of times: what an instruction counter watches. Two counts of different lengths give
// the cost of a run without that of the start.
//   kernels_count --list            kernel:variant, items a run and what an item is, of every case, between tabs
//   kernels_count KERNEL:VARIANT N
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bench/kernels/cases.h"

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--list") == 0) {
    for (const auto& one : im2fit::bench::all_cases()) {
      std::printf("%s:%s\t%.0f\t%s\n", one.kernel.c_str(), one.variant.c_str(), one.items, one.item.c_str());
    }
    return 0;
  }
  char* end = nullptr;
  const long count = argc == 3 ? std::strtol(argv[2], &end, 10) : -1;
  if (count < 0 || *end != '\0') {
    std::fprintf(stderr, "use: %s --list | KERNEL:VARIANT COUNT\n", argv[0]);
    return 2;
  }
  for (const auto& one : im2fit::bench::all_cases(argv[1])) {
    if (one.kernel + ":" + one.variant != argv[1]) continue;
    for (long i = 0; i < count; ++i) one.run();
    return 0;
  }
  std::fprintf(stderr, "%s: no case %s; --list names them\n", argv[0], argv[1]);
  return 2;
}
