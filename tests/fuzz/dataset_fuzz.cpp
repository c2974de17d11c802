// SPDX-License-Identifier: Apache-2.0
// A .i2d shard, which another machine of a cluster may have written: refused with one line, or samples of its head's
// subjects.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/file.h"
#include "tests/fuzz/mutator.h"
#include "train/dataset/dataset_shard.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  static const std::string path = "/dev/shm/im2fit-fuzz-" + std::to_string(::getpid()) + ".i2d";
  static const bool registered = std::atexit([] { ::unlink(path.c_str()); }) == 0;
  if (!registered || !write_file_atomically(path, std::as_bytes(std::span(data, size)))) std::abort();
  const auto about = lab::about_shard(path);
  if (!about) {
    if (about.error().message.empty()) __builtin_trap();
    return 0;
  }
  const auto chunk = lab::read_shard(path, about->run, about->range);
  if (!chunk) return 0;
  for (const index::Sample& s : chunk->samples)
    if (s.subject < about->range.first || s.subject >= about->range.end()) __builtin_trap();
  return 0;
}
