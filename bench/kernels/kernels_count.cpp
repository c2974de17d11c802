// SPDX-License-Identifier: Apache-2.0
// Runs cases for an instruction counter to watch (bench/count, bench/qemu/count.c).
//   kernels_count --list               kernel:variant of every case
//   kernels_count --each [REGEX]       runs the cases that match, but for ref: once, a mark, twice, a mark; prints
//                                      kernel:variant, items and item between tabs, in the order of the marks
//   kernels_count KERNEL:VARIANT N     runs one case N times
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <regex>

#include "bench/kernels/cases.h"

namespace {

using im2fit::bench::all_cases;
using im2fit::bench::Case;

std::string name_of(const Case& one) {
  return one.kernel + ":" + one.variant;
}

// The plugin writes its count when a system call has this first argument. getpid has none and does next to nothing.
void mark() {
  syscall(SYS_getpid, 0x66326d69L);
}

int run_each(const std::string& pattern) {
  const std::regex wanted(pattern);
  // The start of a name, not a pattern: its topic alone is set up.
  const bool plain = pattern.find_first_of("^$.*+?()[]{}|\\") == std::string::npos;
  for (const Case& one : all_cases(plain ? pattern : "")) {
    if (one.tier == im2fit::Tier::ref || !std::regex_search(name_of(one), wanted)) continue;
    // The first run binds library calls and meets cold states.
    one.run();
    mark();
    one.run();
    one.run();
    mark();
    std::printf("%s\t%.0f\t%s\n", name_of(one).c_str(), one.items, one.item.c_str());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--list") == 0) {
    for (const Case& one : all_cases()) std::printf("%s\n", name_of(one).c_str());
    return 0;
  }
  if ((argc == 2 || argc == 3) && std::strcmp(argv[1], "--each") == 0) {
    try {
      return run_each(argc == 3 ? argv[2] : "");
    } catch (const std::regex_error& error) {
      std::fprintf(stderr, "%s: %s is not a regular expression: %s\n", argv[0], argv[2], error.what());
      return 2;
    }
  }
  char* end = nullptr;
  const long count = argc == 3 ? std::strtol(argv[2], &end, 10) : -1;
  if (count < 0 || *end != '\0') {
    std::fprintf(stderr, "use: %s --list | --each [REGEX] | KERNEL:VARIANT COUNT\n", argv[0]);
    return 2;
  }
  for (const Case& one : all_cases(argv[1])) {
    if (name_of(one) != argv[1]) continue;
    for (long i = 0; i < count; ++i) one.run();
    return 0;
  }
  std::fprintf(stderr, "%s: no case %s; --list names them\n", argv[0], argv[1]);
  return 2;
}
