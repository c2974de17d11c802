// SPDX-License-Identifier: Apache-2.0
// Items shared out over threads. Each item must depend on its index only, so that the count of threads never shows.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace im2fit::lab {

// Something long begins: `what`, of `total` items. What it returns is called with the number of items done so far,
// one call at a time. An empty one reports nothing.
using ProgressSink =
    std::function<std::function<void(std::uint64_t done)>(const std::string& what, std::uint64_t total)>;
inline std::function<void(std::uint64_t)> begin_progress(const ProgressSink& sink, const std::string& what,
                                                         std::uint64_t total) {
  return sink ? sink(what, total) : nullptr;
}

inline int default_threads() {
  const unsigned cores = std::thread::hardware_concurrency();
  return cores > 0 ? static_cast<int>(cores) : 1;
}

// Each thread makes itself a worker, which may keep state from one item to the next, and calls it with its share of
// the i below `count`. `on_done`, with the number of items done so far, is called one call at a time.
template <class Index, class MakeWorker>
void for_each_item_by_worker(Index count, int thread_count, const MakeWorker& make_worker,
                             const std::function<void(std::uint64_t)>& on_done = {}) {
  std::atomic<Index> next{0};
  std::mutex mutex;
  std::uint64_t done = 0;
  const auto run = [&] {
    auto work = make_worker();
    for (Index i = next++; i < count; i = next++) {
      work(i);
      if (!on_done) continue;
      const std::lock_guard lock(mutex);
      on_done(++done);
    }
  };
  std::vector<std::jthread> helpers;
  for (int t = 1; t < thread_count && static_cast<Index>(t) < count; ++t) helpers.emplace_back(run);
  run();
}

// work(i) for every i below `count`.
template <class Index, class Work>
void for_each_item(Index count, int thread_count, const Work& work,
                   const std::function<void(std::uint64_t)>& on_done = {}) {
  for_each_item_by_worker(
      count, thread_count, [&] { return [&](Index i) { work(i); }; }, on_done);
}

}  // namespace im2fit::lab
