// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <deque>
#include <thread>
#include <vector>

#include "core/rng.h"
#include "engine/spsc_ring.h"

namespace im2fit {
namespace {

TEST(SpscRing, FillsAndEmptiesInOrder) {
  SpscRing ring(5);
  EXPECT_EQ(ring.capacity(), 8U);
  std::uint32_t item = 0;
  EXPECT_FALSE(ring.try_pop(item));
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_TRUE(ring.try_push(i));
  EXPECT_FALSE(ring.try_push(8));
  for (std::uint32_t i = 0; i < 8; ++i) {
    ASSERT_TRUE(ring.try_pop(item));
    EXPECT_EQ(item, i);
  }
  EXPECT_FALSE(ring.try_pop(item));
}

TEST(SpscRing, AgreesWithADequeOverRandomOperations) {
  SpscRing ring(4);
  std::deque<std::uint32_t> truth;
  Rng rng(3);
  for (std::uint32_t i = 0; i < 20000; ++i) {
    std::uint32_t item = 0;
    switch (rng.index(5)) {
      case 0:
      case 1: {
        const bool fits = truth.size() < 4;
        ASSERT_EQ(ring.try_push(i), fits);
        if (fits) truth.push_back(i);
        break;
      }
      case 2:
      case 3:
        ASSERT_EQ(ring.try_pop(item), !truth.empty());
        if (!truth.empty()) {
          ASSERT_EQ(item, truth.front());
          truth.pop_front();
        }
        break;
      default:
        ASSERT_EQ(ring.take_back_oldest(item), !truth.empty());
        if (!truth.empty()) {
          ASSERT_EQ(item, truth.front());
          truth.pop_front();
        }
    }
    ASSERT_EQ(ring.size_seen_by_producer(), truth.size());
  }
}

TEST(SpscRing, EveryItemComesOutExactlyOnceAcrossThreads) {
  constexpr std::uint32_t kCount = 200000;
  SpscRing ring(8);
  Event filled;
  Event taken;
  std::vector<std::uint8_t> seen(kCount, 0);  // the consumer's and, after joining, ours
  std::uint64_t popped = 0;
  std::thread consumer([&] {
    std::uint32_t last = 0;
    bool any = false;
    for (;;) {
      const std::uint32_t ticket = filled.ticket();
      std::uint32_t item = 0;
      if (!ring.try_pop(item)) {
        filled.wait(ticket);
        continue;
      }
      taken.signal();
      if (item == kCount) return;
      EXPECT_TRUE(!any || item > last) << "out of order";
      any = true;
      last = item;
      ++seen[item];
      ++popped;
    }
  });
  std::vector<std::uint32_t> taken_back;
  for (std::uint32_t i = 0; i <= kCount; ++i) {
    for (;;) {
      const std::uint32_t ticket = taken.ticket();
      if (ring.try_push(i)) break;
      std::uint32_t oldest = 0;
      if (i % 3 == 0 && i < kCount && ring.take_back_oldest(oldest)) {
        taken_back.push_back(oldest);
        continue;
      }
      taken.wait(ticket);
    }
    filled.signal();
  }
  consumer.join();
  for (const std::uint32_t item : taken_back) ++seen[item];
  EXPECT_EQ(popped + taken_back.size(), kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) ASSERT_EQ(seen[i], 1) << "item " << i;
}

}  // namespace
}  // namespace im2fit
