// SPDX-License-Identifier: Apache-2.0
#include "person/size_chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace im2fit {
namespace {

double truth_cdf(double x) {
  return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

TEST(NormalCdf, AgreesWithErfc) {
  for (int i = -800; i <= 800; ++i) {
    const double x = i * 0.01;
    EXPECT_NEAR(normal_cdf(x), truth_cdf(x), 1.5e-7) << x;
  }
  EXPECT_EQ(normal_cdf(1e6), 1.0);
  EXPECT_EQ(normal_cdf(-1e6), 0.0);
}

TEST(SizeChart, BuiltinIsTheFilesAndTheStandardsTable) {
  for (const bool women : {false, true}) {
    const SizeChart& chart = women ? builtin_size_system().women : builtin_size_system().men;
    auto file =
        load_size_chart(std::string(IM2FIT_SIZE_CHARTS) + (women ? "/en13402-3-women.csv" : "/en13402-3-men.csv"));
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(chart.name, "EN 13402-3");
    EXPECT_EQ(chart.sex, women ? ChartSex::women : ChartSex::men);
    EXPECT_FALSE(chart.source.empty());
    EXPECT_FALSE(chart.date.empty());
    ASSERT_EQ(chart.rows.size(), 7U);
    ASSERT_EQ(file->rows.size(), 7U);
    const float men_cm[8] = {78, 86, 94, 102, 110, 118, 129, 141};
    const float women_cm[8] = {74, 82, 90, 98, 107, 119, 131, 143};
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_EQ(chart.rows[i].low_mm, 10 * (women ? women_cm : men_cm)[i]);
      EXPECT_EQ(chart.rows[i].high_mm, 10 * (women ? women_cm : men_cm)[i + 1]);
      EXPECT_EQ(chart.rows[i].size, file->rows[i].size);
      EXPECT_EQ(chart.rows[i].low_mm, file->rows[i].low_mm);
    }
  }
}

std::map<std::string, double> as_map(const SizeAnswer& answer) {
  std::map<std::string, double> map;
  double sum = 0;
  for (const auto& entry : answer.entries) {
    EXPECT_TRUE(map.emplace(entry.size, entry.probability).second) << entry.size << " twice";
    EXPECT_GE(entry.probability, 0);
    sum += entry.probability;
  }
  EXPECT_NEAR(sum, 1, 1e-12);
  return map;
}

TEST(SizeProbabilities, OnAnEdgeAreHalfAndHalf) {
  const SizeAnswer answer = size_probabilities(builtin_size_system(), {1020, 1000, 1040}, 0);
  const auto p = as_map(answer);
  EXPECT_NEAR(p.at("M"), 0.5, 1e-6);
  EXPECT_NEAR(p.at("L"), 0.5, 1e-6);
  EXPECT_EQ(answer.chart, "EN 13402-3");
}

// Whoever is between two sizes, which a chart leaves apart, takes the nearer.
TEST(SizeProbabilities, AGapBetweenSizesIsSharedByBoth) {
  SizeSystem sizes = builtin_size_system();
  for (std::size_t i = 0; i < sizes.men.rows.size(); ++i) {
    if (sizes.men.rows[i].size != "M") continue;
    sizes.men.rows[i].high_mm -= 20;
    sizes.men.rows.at(i + 1).low_mm += 30;
  }
  const auto p = as_map(size_probabilities(sizes, {1025, 1005, 1045}, 0));  // M to 1000, L from 1050
  EXPECT_NEAR(p.at("M"), 0.5, 1e-6);
  EXPECT_NEAR(p.at("L"), 0.5, 1e-6);
}

TEST(SizeProbabilities, FollowTheInterval) {
  const SizeAnswer answer = size_probabilities(builtin_size_system(), {1000, 960.8F, 1039.2F}, 0);
  const auto p = as_map(answer);
  const double sd = 78.4 / (2 * 1.959963984540054);
  EXPECT_NEAR(p.at("M"), truth_cdf(20 / sd) - truth_cdf(-60 / sd), 1e-5);
  EXPECT_NEAR(p.at("L"), truth_cdf(100 / sd) - truth_cdf(20 / sd), 1e-5);
  EXPECT_EQ(answer.best, "M");
}

TEST(SizeProbabilities, AreMixedByTheSexes) {
  // 1000 +- 4 mm: M for a man (940-1020), L for a woman (980-1070).
  const index::IntervalEstimate chest{1000, 996, 1004};
  EXPECT_EQ(size_probabilities(builtin_size_system(), chest, 0).best, "M");
  EXPECT_EQ(size_probabilities(builtin_size_system(), chest, 1).best, "L");
  const auto p = as_map(size_probabilities(builtin_size_system(), chest, 0.3F));
  EXPECT_NEAR(p.at("M"), 0.7, 1e-6);
  EXPECT_NEAR(p.at("L"), 0.3, 1e-6);
}

TEST(SizeProbabilities, SayWhenAPersonIsOutsideTheChart) {
  EXPECT_EQ(size_probabilities(builtin_size_system(), {600, 590, 610}, 0.5F).best, "<XS");
  EXPECT_EQ(size_probabilities(builtin_size_system(), {1600, 1590, 1610}, 0.5F).best, ">3XL");
}

std::string read(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(SizeChart, ErrorsNameFileLineAndField) {
  const std::string good = read(std::string(IM2FIT_SIZE_CHARTS) + "/en13402-3-men.csv");
  struct Case {
    const char* from;
    const char* to;
    const char* message;
  };
  const Case cases[] = {
      {"# unit: mm", "# unit: inch", "chart.csv line 3: unit is 'inch', expected 'mm'"},
      {"# sex: men", "# sex: boys", "chart.csv line 2: sex is 'boys'"},
      {"# name: EN 13402-3\n", "", "has no '# name:' line"},
      {"# sex: men\n", "", "has no '# sex:' line"},
      {"# source:", "# origin:", "has no '# source:' line"},
      {"# date: 2004\n", "", "has no '# date:' line"},
      {"size,low_mm,high_mm", "size;low;high", "chart.csv line 6: column line is 'size,low,high'"},
      {"S,860,940", "S,860", "chart.csv line 8: row 'S,860'"},
      {"S,860,940", "S,860,940,1", "chart.csv line 8: row"},
      {"S,860,940", ",860,940", "chart.csv line 8: size must have"},
      {"S,860,940", "S,abc,940", "chart.csv line 8: low_mm is 'abc'"},
      {"S,860,940", "S,860,nan", "chart.csv line 8: high_mm is 'nan'"},
      {"S,860,940", "S,860,94x", "chart.csv line 8: high_mm is '94x'"},
      {"S,860,940", "S,860,940.", "chart.csv line 8: high_mm is '940.'"},
      {"S,860,940", "S,860,-940", "chart.csv line 8: high_mm is '-940'"},
      {"S,860,940", "S,860,99999999999", "chart.csv line 8: high_mm is"},
      {"S,860,940", "S,860,860", "chart.csv line 8: high_mm must be more"},
      {"S,860,940", "S,850,940", "chart.csv line 8: low_mm overlaps size XS"},
      {"S,860,940", "XS,860,940", "chart.csv line 8: size 'XS' appears twice"},
  };
  for (const Case& c : cases) {
    auto chart = parse_size_chart(replaced(good, c.from, c.to), "chart.csv");
    ASSERT_FALSE(chart) << c.to;
    EXPECT_THAT(chart.error().message, testing::HasSubstr(c.message));
  }
  // Values no chest has: centimetres, and whatever else.
  EXPECT_THAT(
      parse_size_chart(replaced(good, "XS,780,860", "XS,78,86"), "chart.csv").error().message,
      testing::HasSubstr("low_mm is '78' mm, expected a chest girth of 300 to 2500 mm; if these are centimetres"));
  EXPECT_FALSE(parse_size_chart(replaced(good, "3XL,1290,1410", "3XL,1290,14100"), "chart.csv"));
  EXPECT_FALSE(parse_size_chart("", "chart.csv"));
  EXPECT_FALSE(parse_size_chart(std::string(100000, 'x'), "chart.csv"));
  EXPECT_FALSE(load_size_chart("/nonexistent/chart.csv"));
  auto decimals = parse_size_chart(replaced(good, "S,860,940", "S, 860.25 ,940"), "chart.csv");
  ASSERT_TRUE(decimals);
  EXPECT_EQ(decimals->rows[1].low_mm, 860.25F);
  EXPECT_TRUE(parse_size_chart(replaced(good, "XS,780,860\n", "XS,780,860\r\n"), "chart.csv")) << "DOS line ends";
}

// As spreadsheets write it.
TEST(SizeChart, WhatSpreadsheetsMakeOfAChartIsRead) {
  const std::string head = "# name: ACME\n# sex: any\n# unit: mm\n# source: x\n# date: 2020\n";
  const std::string rows = "size,low_mm,high_mm\nS,860,940\nM,940,1020\n";
  std::string semicolons = head + rows;
  std::replace(semicolons.begin(), semicolons.end(), ',', ';');
  std::string tabs = head + rows;
  std::replace(tabs.begin(), tabs.end(), ',', '\t');
  const std::string padded =
      "# name: ACME,,\n# sex: any,,\n# unit: mm,,\n# source: x,,\n# date: 2020,,\n,,\n"
      "size,low_mm,high_mm,,\nS, 860 ,940,,\n,,,,\nM,940,1020,,\n";
  const std::string kinds[] = {head + rows,
                               "\xEF\xBB\xBF" + head + rows,
                               semicolons,
                               tabs,
                               padded,
                               "sep=;\r\n" + semicolons,
                               "\"# name: ACME\"\n# sex: any\n# unit: mm\n\"# source: a, b\"\n# date: "
                               "2020\n\"size\",\"low_mm\",\"high_mm\"\n"
                               "\"S\",\"860\",\"940\"\n\"M\",\"940\",\"1020\"\n"};
  for (const std::string& text : kinds) {
    const auto chart = parse_size_chart(text, "chart.csv");
    ASSERT_TRUE(chart) << chart.error().message << "\n" << text;
    EXPECT_EQ(chart->name, "ACME") << text;
    ASSERT_EQ(chart->rows.size(), 2U) << text;
    EXPECT_EQ(chart->rows[0].size, "S");
    EXPECT_EQ(chart->rows[1].high_mm, 1020);
  }
  const auto commas = parse_size_chart(
      "# name: A\n# sex: any\n# unit: mm\n# source: x\n# date: 1\n"
      "size;low_mm;high_mm\nS;860,5;940,25\n",
      "chart.csv");
  ASSERT_TRUE(commas) << commas.error().message;
  EXPECT_EQ(commas->rows[0].low_mm, 860.5F);
  EXPECT_EQ(commas->rows[0].high_mm, 940.25F);
  const auto letters = parse_size_chart(head + "size,low_mm,high_mm\nGröße M/L weit,940,1100\n特大,1100,1180\n", "c");
  ASSERT_TRUE(letters) << letters.error().message;
  EXPECT_FALSE(parse_size_chart(head + "size,low_mm,high_mm\n0123456789abcdef,940,1100\n", "c"));
  EXPECT_FALSE(parse_size_chart(head + "size,low_mm,high_mm\n特大特大特大特大特大特大,940,1100\n", "c"))
      << "36 bytes";
}

TEST(SizeSystem, NeedsOneForAllOrOneOfEach) {
  const SizeSystem& both = builtin_size_system();
  auto swapped = make_size_system({both.women, both.men});
  ASSERT_TRUE(swapped);
  EXPECT_EQ(swapped->men.rows[0].low_mm, 780);
  SizeChart any = both.men;
  any.sex = ChartSex::any;
  EXPECT_TRUE(make_size_system({any}));
  EXPECT_FALSE(make_size_system({both.men}));
  EXPECT_FALSE(make_size_system({both.men, both.men}));
  EXPECT_FALSE(make_size_system({}));
  SizeChart other = both.women;
  other.name = "other";
  EXPECT_FALSE(make_size_system({both.men, other}));
}

}  // namespace
}  // namespace im2fit
