// SPDX-License-Identifier: Apache-2.0
#include "engine/snapshot.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>
#include <vector>

namespace im2fit {
namespace {

struct Value {
  std::uint32_t number = 0;
  std::array<std::uint32_t, 40> copies{};
  std::uint8_t tail = 0;
};

Value make(std::uint32_t number) {
  Value value;
  value.number = number;
  value.copies.fill(number * 3);
  value.tail = static_cast<std::uint8_t>(number);
  return value;
}

TEST(Snapshot, ReadsWhatWasPublishedLast) {
  Snapshot<Value> snapshot(make(5));
  EXPECT_EQ(snapshot.read().number, 5U);
  for (std::uint32_t i = 6; i < 12; ++i) {
    snapshot.publish(make(i));
    EXPECT_EQ(snapshot.read().number, i);
    EXPECT_EQ(snapshot.read().copies[39], 3 * i);
  }
}

TEST(Snapshot, NeverTornAndNeverBackwardsForSeveralReaders) {
  constexpr std::uint32_t kCount = 50000;
  Snapshot<Value> snapshot(make(0));
  std::vector<std::thread> readers;
  for (int r = 0; r < 3; ++r)
    readers.emplace_back([&] {
      std::uint32_t last = 0;
      while (last < kCount) {
        const Value value = snapshot.read();
        ASSERT_GE(value.number, last);
        for (const std::uint32_t copy : value.copies) ASSERT_EQ(copy, value.number * 3);
        ASSERT_EQ(value.tail, static_cast<std::uint8_t>(value.number));
        last = value.number;
      }
    });
  for (std::uint32_t i = 1; i <= kCount; ++i) snapshot.publish(make(i));
  for (auto& reader : readers) reader.join();
}

}  // namespace
}  // namespace im2fit
