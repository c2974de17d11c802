// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/board.h"

#include <gtest/gtest.h>

#include <thread>

namespace im2fit::apps {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLong{20'000};

TEST(Board, TellsTheLatestOfEachKindInOrder) {
  Board board;
  board.publish("state", "a");
  board.publish("frame", "b");
  board.publish("state", "c");
  std::uint64_t seen = 0;
  EXPECT_EQ(board.wait(seen, kLong), "data: b\n\ndata: c\n\n");
  EXPECT_EQ(board.wait(seen, milliseconds(1)), "");
  board.publish("frame", "d");
  EXPECT_EQ(board.wait(seen, kLong), "data: d\n\n");
  std::uint64_t late = 0;  // a later client gets the same
  EXPECT_EQ(board.wait(late, kLong), "data: c\n\ndata: d\n\n");
}

TEST(Board, WhoWaitsIsWoken) {
  Board board;
  std::string got;
  std::thread reader([&] {
    std::uint64_t seen = 0;
    got = board.wait(seen, kLong);
  });
  board.publish("state", "now");
  reader.join();
  EXPECT_EQ(got, "data: now\n\n");

  std::string after = "unset";
  std::thread patient([&] {
    std::uint64_t seen = 1;
    after = board.wait(seen, kLong);
  });
  board.close();
  patient.join();
  EXPECT_EQ(after, "");
  EXPECT_TRUE(board.closed());
}

TEST(Board, AFileStaysWithWhoReadsIt) {
  Board board;
  EXPECT_EQ(board.file("/a"), nullptr);
  board.put("/a", {"text/plain", "old"});
  const auto held = board.file("/a");
  board.put("/a", {"text/plain", "new"});
  EXPECT_EQ(held->bytes, "old");
  EXPECT_EQ(board.file("/a")->bytes, "new");
}

}  // namespace
}  // namespace im2fit::apps
