// SPDX-License-Identifier: Apache-2.0
// Runs cases for an instruction counter to watch (bench/count, bench/qemu/count.c).
//   bench_count LIST --list               kernel:variant of every case
//   bench_count LIST --each [REGEX]       runs the cases that match, but for ref: once, a mark, twice, a mark; prints
//                                         kernel:variant, items and item between tabs, in the order of the marks
//   bench_count LIST KERNEL:VARIANT N     runs one case N times
// LIST: kernels, frame, growth or, where garments are built, cloth (cases.h).
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <regex>

#include "bench/kernels/cases.h"

namespace {

using im2fit::bench::Case;
using im2fit::bench::CaseList;

std::string name_of(const Case& one) {
  return one.kernel + ":" + one.variant;
}

// The plugin writes its count when a system call has this first argument. getpid has none and does next to nothing.
void mark() {
  syscall(SYS_getpid, 0x66326d69L);
}

int run_each(const CaseList& list, const std::string& pattern) {
  const std::regex wanted(pattern);
  // The start of a name, not a pattern: its topic alone is set up.
  const bool plain = pattern.find_first_of("^$.*+?()[]{}|\\") == std::string::npos;
  for (const Case& one : list.cases(plain ? pattern : "")) {
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
  const CaseList* list = argc > 2 ? im2fit::bench::case_list(argv[1]) : nullptr;
  if (list != nullptr && argc == 3 && std::strcmp(argv[2], "--list") == 0) {
    for (const Case& one : list->cases({})) std::printf("%s\n", name_of(one).c_str());
    return 0;
  }
  if (list != nullptr && argc <= 4 && std::strcmp(argv[2], "--each") == 0) {
    try {
      return run_each(*list, argc == 4 ? argv[3] : "");
    } catch (const std::regex_error& error) {
      std::fprintf(stderr, "%s: %s is not a regular expression: %s\n", argv[0], argv[3], error.what());
      return 2;
    }
  }
  char* end = nullptr;
  const long count = list != nullptr && argc == 4 ? std::strtol(argv[3], &end, 10) : -1;
  if (count < 0 || *end != '\0') {
    std::fprintf(stderr, "use: %s LIST --list | LIST --each [REGEX] | LIST KERNEL:VARIANT COUNT; LIST: %s\n", argv[0],
                 im2fit::bench::case_list_names().c_str());
    return 2;
  }
  for (const Case& one : list->cases(argv[2])) {
    if (name_of(one) != argv[2]) continue;
    for (long i = 0; i < count; ++i) one.run();
    return 0;
  }
  std::fprintf(stderr, "%s: no case %s; --list names them\n", argv[0], argv[2]);
  return 2;
}
