// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstring>

#include "kernels/undistort/undistort.h"

namespace im2fit {
namespace {

constexpr std::int32_t kBlock = 8;  // pixels in a register

}  // namespace

std::vector<UndistortRun> undistort_runs(std::span<const std::int32_t> table) {
  std::vector<UndistortRun> runs;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const std::int32_t from = table[i] < 0 ? -1 : table[i];
    if (!runs.empty()) {
      UndistortRun& last = runs.back();
      const std::int32_t next = last.from < 0 ? -1 : last.from + last.count;
      if (from == next) {
        ++last.count;
        continue;
      }
    }
    runs.push_back({static_cast<std::int32_t>(i), from, 1});
  }
  return runs;
}

// Blocks may end past their run, as the next run writes there after; near the end of a picture they may not.
void undistort_portable(const std::uint16_t* in, int pixels, const UndistortRun* runs, int run_count,
                        std::uint16_t* out) {
  for (int i = 0; i < run_count; ++i) {
    const UndistortRun run = runs[i];
    std::uint16_t* to = out + run.to;
    if (run.from < 0) {
      std::memset(to, 0, static_cast<std::size_t>(run.count) * sizeof *to);
      continue;
    }
    const std::uint16_t* from = in + run.from;
    const std::int32_t room = pixels - (run.to > run.from ? run.to : run.from);
    std::int32_t k = 0;
    for (; k < run.count && k + kBlock <= room; k += kBlock) std::memcpy(to + k, from + k, kBlock * sizeof *to);
    for (; k < run.count; ++k) to[k] = from[k];
  }
}

void undistort(const std::uint16_t* in, int pixels, const UndistortRun* runs, int run_count, std::uint16_t* out) {
  IM2FIT_CHOSEN_ONCE best = fastest(kUndistortKernels);
  best(in, pixels, runs, run_count, out);
}

}  // namespace im2fit
