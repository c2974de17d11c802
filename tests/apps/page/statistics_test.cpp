// SPDX-License-Identifier: Apache-2.0
// Counts without persons: what the file says, that it goes on, and that a spoiled one is refused by its line.
#include "apps/kiosk/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace im2fit::apps {
namespace {

using testing::HasSubstr;

class StatisticsFile : public testing::Test {
 protected:
  StatisticsFile() {
    std::string name = (std::filesystem::temp_directory_path() / "im2fit-count-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    path_ = folder_ + "/visits.csv";
  }
  ~StatisticsFile() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  void write(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }
  std::string text() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::string folder_, path_;
};

TEST_F(StatisticsFile, CountsDaysAndMonthsAndGoesOn) {
  for (int run = 1; run <= 2; ++run) {
    auto statistics = Statistics::open(path_);
    ASSERT_TRUE(statistics) << statistics.error().message;
    Statistics& all = **statistics;
    for (const char* day : {"2026-11-30", "2026-11-30", "2026-12-01", "2026-11-30"}) all.visit(day);
    all.measured("2026-11-30", "M");
    all.measured("2026-11-30", "M");
    all.measured("2026-12-01", "");
    all.not_measured("2026-11-30", "MOVING");
    const std::string n = std::to_string(run), n2 = std::to_string(2 * run), n3 = std::to_string(3 * run);
    EXPECT_EQ(all.csv(), "period,what,name,count\n2026-11,not_measured,MOVING," + n + "\n2026-11,size,M," + n2 +
                             "\n2026-11-30,measured,," + n2 + "\n2026-11-30,visits,," + n3 +
                             "\n2026-12-01,measured,," + n + "\n2026-12-01,visits,," + n + "\n");
    ASSERT_TRUE(all.flush());
    EXPECT_EQ(text(), all.csv());
  }
  struct stat about {};
  ASSERT_EQ(::stat(path_.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U) << "its owner alone reads it";
}

TEST_F(StatisticsFile, ASizeOfAnyNameIsOneCell) {
  {
    auto statistics = Statistics::open(path_);
    ASSERT_TRUE(statistics);
    (*statistics)->measured("2026-11-30", "34\"/32\", long;\n" + std::string(100, 'x'));
    ASSERT_TRUE((*statistics)->flush());
  }
  const auto again = Statistics::open(path_);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_THAT((*again)->csv(), HasSubstr("2026-11,size,34 /32   long  xxx"));
}

// Found by the fuzzer: blanks at the ends and the formula's quote made another name of it at each start.
TEST_F(StatisticsFile, ANameIsTheSameAtEachStart) {
  for (const std::string& name : {std::string("\x06\x06 M \x06"), "=" + std::string(80, 'x'),
                                  std::string(58, 'x') + "   y", std::string("\x06")}) {
    write("period,what,name,count\n2026-11,size," + name + ",1\n");
    const auto first = Statistics::open(path_);
    ASSERT_TRUE(first) << first.error().message;
    const auto second = Statistics::open(path_);
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_EQ((*first)->csv(), (*second)->csv());
  }
}

TEST_F(StatisticsFile, NoSizeIsAFormulaAndAFileThatWasEditedOpensTwice) {
  write("period,what,name,count\n2026-11,size,\"36,5\",1\n");
  for (int run = 0; run < 2; ++run) {
    const auto statistics = Statistics::open(path_);
    ASSERT_TRUE(statistics) << statistics.error().message;
    (*statistics)->measured("2026-11-30", "=1+1");
    ASSERT_TRUE((*statistics)->flush());
  }
  EXPECT_THAT(text(), HasSubstr("2026-11,size,36 5,1\n"));
  EXPECT_THAT(text(), HasSubstr("2026-11,size,'=1+1,2\n"));
  // Cut between letters: 59 of a byte, then one of two.
  const auto statistics = Statistics::open(path_);
  ASSERT_TRUE(statistics);
  (*statistics)->measured("2026-12-01", std::string(59, 'x') + "\xC3\xA4");
  EXPECT_THAT((*statistics)->csv(), HasSubstr("2026-12,size," + std::string(59, 'x') + ",1\n"));
}

TEST_F(StatisticsFile, ASpoiledOneIsRefusedByItsLineAndStays) {
  const std::string head = "period,what,name,count\n";
  for (const auto& [spoiled, expected] :
       {std::pair<std::string, const char*>{"", "expected the columns period,what,name,count"},
        {"a,b,c,d\n", ":1: expected the columns"},
        {head + "2026-11-30,visits,,1\n2026-11-30,visits\n", ":3: has 2 cells, expected 4"},
        {head + "2026-11,visits,,1\n", ":2: period is 2026-11, expected 2026-11-30"},
        {head + "2026-11-30,size,M,1\n", ":2: period is 2026-11-30, expected 2026-11"},
        {head + "2026-11-30,people,,1\n", ":2: what is people, expected visits"},
        {head + "2026-11-30,visits,,-1\n", ":2: count is -1, expected a number"},
        {head + "2026-11-30,visits,,1e3\n", ":2: count is 1e3, expected a number"}}) {
    write(spoiled);
    const auto statistics = Statistics::open(path_);
    ASSERT_FALSE(statistics) << spoiled;
    EXPECT_THAT(statistics.error().message, HasSubstr(path_));
    EXPECT_THAT(statistics.error().message, HasSubstr(expected));
    EXPECT_EQ(text(), spoiled);
  }
  EXPECT_FALSE(Statistics::open(folder_ + "/none/visits.csv")) << "found out at the start";
}

TEST_F(StatisticsFile, WhatCannotBeWrittenNowIsWrittenLater) {
  auto statistics = Statistics::open(path_);
  ASSERT_TRUE(statistics);
  (*statistics)->visit("2026-11-30");
  std::filesystem::rename(folder_, folder_ + "-away");
  EXPECT_FALSE((*statistics)->flush());
  std::filesystem::rename(folder_ + "-away", folder_);
  EXPECT_TRUE((*statistics)->flush());
  EXPECT_THAT(text(), HasSubstr("2026-11-30,visits,,1"));
}

TEST(StatisticsDay, IsADay) {
  EXPECT_THAT(local_day(), testing::MatchesRegex("[0-9][0-9][0-9][0-9]-[0-9][0-9]-[0-9][0-9]"));
}

}  // namespace
}  // namespace im2fit::apps
