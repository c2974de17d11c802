// SPDX-License-Identifier: Apache-2.0
#include "formats/csv.h"

#include <gtest/gtest.h>

namespace im2fit {
namespace {

using Row = std::vector<std::string>;
using Rows = std::vector<Row>;

const std::string kName = "t.csv";

Rows rows_of(const std::string& text, std::string* error = nullptr) {
  CsvReader csv(text, kName);
  Rows rows;
  for (Row row;;) {
    const auto more = csv.next(row);
    if (!more && error != nullptr) *error = more.error().message;
    if (!more || !*more) return rows;
    rows.push_back(row);
  }
}

TEST(Csv, WhatSpreadsheetsWriteIsTheSameTable) {
  const Rows table = {{"size", "low", "high"}, {"S", "86.5", "94"}};
  for (const char* text :
       {"size,low,high\nS,86.5,94\n", "size,low,high\r\nS,86.5,94", "\xEF\xBB\xBFsize,low,high\nS,86.5,94\n",
        "size;low;high\nS;86.5;94\n", "size\tlow\thigh\nS\t86.5\t94\n", "sep=;\r\nsize;low;high\r\nS;86.5;94\r\n",
        "\"size\",\"low\",\"high\"\n\"S\",\"86.5\",\"94\"\n", " size , low , high \n\n S , 86.5 ,\" 94 \"\n",
        "size,low,high,,\n,,,,\nS,86.5,94,,\n", "size;low;high;;\n;;;;\nS;86.5;94;;\n"})
    EXPECT_EQ(rows_of(text), table) << text;
}

TEST(Csv, QuotesHoldSeparatorsAndQuotes) {
  EXPECT_EQ(rows_of("a,\"b,c\",\"d\"\"e\"\n"), (Rows{{"a", "b,c", "d\"e"}}));
  EXPECT_EQ(rows_of("a,,c\n"), (Rows{{"a", "", "c"}})) << "an empty cell between others stays";
}

TEST(Csv, CommentsAreOneCellWhateverASpreadsheetDid) {
  for (const char* text :
       {"# source: a, b\n", "\"# source: a, b\"\n", "# source: a, b,,,\n", "\"# source: a, b\",,\n"})
    EXPECT_EQ(rows_of(text), (Rows{{"# source: a, b"}})) << text;
}

TEST(Csv, WhatIsNoTableIsRefusedWithItsLine) {
  const std::pair<std::string, const char*> kBad[] = {
      {"a,b\n\"c,d\n", "t.csv line 2: has a quote that is not closed"},
      {"a,b\n\"c\"d,e\n", "t.csv line 2: has text behind a quoted cell"},
      {"a" + std::string(100, ',') + "b\n", "t.csv line 1: has more than 64 cells"},
      {std::string(300, 'a') + "\n", "t.csv line 1: has a cell of more than 256 bytes"},
      {"#" + std::string(2000, 'a') + "\n", "too long a comment"},
      {std::string("\xFF\xFE"
                   "a\0",
                   4),
       "t.csv line 1: is UTF-16"},
      {std::string("a\0b\n", 4), "not text"},
  };
  for (const auto& [text, expected] : kBad) {
    std::string error;
    rows_of(text, &error);
    EXPECT_NE(error.find(expected), std::string::npos) << error << " for " << expected;
  }
  EXPECT_TRUE(rows_of("").empty());
  EXPECT_TRUE(rows_of("\n\r\n , ,\n").empty());
}

TEST(Csv, NumbersHaveAPointOrWhereItIsNoSeparatorAComma) {
  Row row;
  double value = 0;
  CsvReader points("a,b\n", kName), commas("a;b\n", kName);
  ASSERT_TRUE(points.next(row) && commas.next(row));
  for (const auto& [text, expected] : {std::pair{"86.5", 86.5}, {"-3", -3.0}, {"+0.25", 0.25}, {"1020", 1020.0}}) {
    ASSERT_TRUE(points.number(text, value)) << text;
    EXPECT_DOUBLE_EQ(value, expected);
  }
  for (const char* text : {"", "-", "86,5", "86.", ".5", "1e3", "nan", "86 cm", "0x10", "99999999999999999999"})
    EXPECT_FALSE(points.number(text, value)) << text;
  ASSERT_TRUE(commas.number("86,5", value));
  EXPECT_DOUBLE_EQ(value, 86.5);
}

TEST(Csv, TellsWhetherTheLastRowIsWhole) {
  Row row;
  CsvReader csv("a,b\n1", kName);
  ASSERT_TRUE(csv.next(row));
  EXPECT_FALSE(csv.cut_off());
  ASSERT_TRUE(csv.next(row));
  EXPECT_TRUE(csv.cut_off());
  EXPECT_EQ(csv.line(), 2);
}

}  // namespace
}  // namespace im2fit
