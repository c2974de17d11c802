// SPDX-License-Identifier: Apache-2.0
// Items shared out over threads. Each item must depend on its index only, so that the count of threads never shows.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace im2fit::lab {

template <class Work>
void for_each_item(int item_count, int thread_count, const Work& work) {
  if (thread_count <= 1 || item_count <= 1) {
    for (int i = 0; i < item_count; ++i) work(i);
    return;
  }
  std::atomic<int> next{0};
  std::vector<std::jthread> threads;
  for (int t = 0; t < thread_count && t < item_count; ++t)
    threads.emplace_back([&] {
      for (int i = next++; i < item_count; i = next++) work(i);
    });
}

}  // namespace im2fit::lab
