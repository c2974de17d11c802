// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "engine/report/progress.h"

namespace im2fit::lab {

inline int default_threads() {
  const unsigned cores = std::thread::hardware_concurrency();
  return cores > 0 ? static_cast<int>(cores) : 1;
}

// work(i) for every i below `count`, on `threads` threads, with progress. Items must not depend on each other.
inline void parallel_items(const std::string& what, std::uint64_t count, int threads,
                           const std::function<void(std::uint64_t)>& work) {
  Progress progress(what, count);
  std::atomic<std::uint64_t> next{0};
  std::uint64_t done = 0;
  std::mutex mutex;
  const auto worker = [&] {
    for (std::uint64_t i = next++; i < count; i = next++) {
      work(i);
      const std::lock_guard lock(mutex);
      progress.update(++done);
    }
  };
  std::vector<std::thread> helpers;
  for (int t = 1; t < threads; ++t) helpers.emplace_back(worker);
  worker();
  for (auto& helper : helpers) helper.join();
}

}  // namespace im2fit::lab
