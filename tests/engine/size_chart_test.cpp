// SPDX-License-Identifier: Apache-2.0
#include "person/size_chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
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
      {"# unit: mm", "# unit: ell", "chart.csv line 3: unit is 'ell', expected mm, cm or in"},
      {"# unit: mm", "# unit: inch", "chart.csv line 6: column low_mm is in mm, and '# unit:' is in"},
      {"# sex: men", "# sex: boys", "chart.csv line 2: sex is 'boys'"},
      {"# name: EN 13402-3\n", "", "has no '# name:' line"},
      {"# sex: men\n", "", "has no '# sex:' line"},
      {"# source:", "# origin:", "has no '# source:' line"},
      {"# date: 2004\n", "", "has no '# date:' line"},
      {"size,low_mm,high_mm", "size;low;tall", "chart.csv line 6: column line is 'size,low,tall'"},
      {"size,low_mm,high_mm", "size,low_mm,high_mm,weight", "'weight' is not known: remove the column"},
      {"size,low_mm,high_mm", "size,low_mm,waist", "chest_girth has a low or a high end alone"},
      {"size,low_mm,high_mm", "low_mm,high_mm", "chart.csv line 6: column line"},
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
      {"S,860,940", "S,800,850", "size 'S' lies within size 'XS'"},
      {"S,860,940", "XS,860,940", "chart.csv line 8: size 'XS' appears twice"},
  };
  for (const Case& c : cases) {
    auto chart = parse_size_chart(replaced(good, c.from, c.to), "chart.csv");
    ASSERT_FALSE(chart) << c.to;
    EXPECT_THAT(chart.error().message, testing::HasSubstr(c.message));
  }
  // Values no chest has: centimetres, and whatever else.
  EXPECT_THAT(parse_size_chart(replaced(good, "XS,780,860", "XS,78,86"), "chart.csv").error().message,
              testing::HasSubstr("low_mm is '78' mm, expected a chest girth of 300 to 2500 mm; if these are "
                                 "centimetres, write '# unit: cm'"));
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

const std::string kHead = "# name: shop\n# sex: any\n# source: shop\n# date: 2026\n";

SizeChart chart_of(const std::string& text) {
  auto chart = parse_size_chart(text, "shop.csv");
  EXPECT_TRUE(chart) << chart.error().message << "\n" << text;
  return chart ? *chart : SizeChart{};
}

TEST(SizeChart, UnitsAndNamesOfShopsAreRead) {
  for (const char* text :
       {"# unit: mm\nsize,low_mm,high_mm\nS,914.4,965.2\nM,965.2,1016\n",
        "# unit: cm\nsize,low_cm,high_cm\nS,91.44,96.52\nM,96.52,101.6\n",
        "# unit: in\nsize,low,high\nS,36,38\nM,38,40\n", "# unit: inches\nSize,Bust\nS,36-38\nM,38-40\n",
        "Size,Chest (in)\nM,38 - 40\nS,36 to 38\n", "Size,Chest (in)\nM,38in-40 in\nS,36-38\n",
        "Size;Chest girth [cm]\nM;96,52–101,6\nS;91,44–96,52\n",
        "# unit: in\nsize,chest_min,chest_max\nM,38,40\nS,36,38\n"}) {
    const bool plain = text[0] == 'S';
    const SizeChart chart = chart_of(plain ? text : kHead + text);
    ASSERT_EQ(chart.rows.size(), 2U) << text;
    EXPECT_EQ(chart.name, "shop");
    EXPECT_EQ(chart.measures, std::vector<std::string>{"chest_girth"});
    EXPECT_EQ(chart.rows[0].size, "S") << text;
    EXPECT_NEAR(chart.rows[0].low_mm, 914.4, 1e-3) << text;
    EXPECT_NEAR(chart.rows[1].high_mm, 1016, 1e-3) << text;
  }
  EXPECT_THAT(parse_size_chart("Size,Chest\nS,86-94\n", "shop.csv").error().message,
              testing::HasSubstr("has no unit; write it as 'Chest (cm)'"));
  const SizeChart many = chart_of(
      "Size,Waist (in),Inseam (cm),hips_cm,knee mm,under_bust_girth_mm\n"
      "W32/L34,32,86,98-104,380,800\n");
  EXPECT_EQ(many.measures,
            (std::vector<std::string>{"waist_girth", "inside_leg", "hip_girth", "knee_girth", "under_bust_girth"}));
}

// One value a size: half the way to the next.
TEST(SizeChart, OneValueASizeReachesHalfWayToTheNext) {
  const SizeChart chart = chart_of("Size,Chest (cm)\n36,80\n34,76\n40,90\n");
  ASSERT_EQ(chart.rows.size(), 3U);
  EXPECT_EQ(chart.rows[0].low_mm, 740);
  EXPECT_EQ(chart.rows[0].high_mm, 780);
  EXPECT_EQ(chart.rows[1].high_mm, 850);
  EXPECT_EQ(chart.rows[2].high_mm, 950);
  EXPECT_THAT(parse_size_chart("Size,Chest (cm)\nS,80\nM,84-90\n", "shop.csv").error().message,
              testing::HasSubstr("shop.csv line 2: high_mm must be more"));
}

MeasureLookup body_of(const std::map<std::string, index::IntervalEstimate>& values) {
  return [values](std::string_view id) {
    const auto it = values.find(std::string(id));
    return it == values.end() ? std::nullopt : std::optional(it->second);
  };
}

// Whoever lies where two sizes overlap takes either.
TEST(SizeAnswer, AnOverlapIsSharedByBoth) {
  const SizeChart chart = chart_of("Size,Chest (cm)\nS,86-93\nM,91-99\n");
  const auto p = as_map(size_answer({chart, chart}, body_of({{"chest_girth", {920, 900, 940}}}), 0));
  EXPECT_NEAR(p.at("S"), 0.5, 1e-6);
  EXPECT_NEAR(p.at("M"), 0.5, 1e-6);
}

TEST(SizeAnswer, AChartByTheWaistAloneDoesNotAskForTheChest) {
  const SizeChart chart = chart_of("Size,Waist (in)\n30,30\n32,32\n34,34\n");
  EXPECT_FALSE(chart.has_chest());
  const SizeAnswer answer = size_answer({chart, chart}, body_of({{"waist_girth", {815, 810, 820}}}), 0.5F);
  EXPECT_EQ(answer.best, "32");
  EXPECT_GT(as_map(answer).at("32"), 0.99);
  EXPECT_FALSE(answer.reason);
  const SizeSystem system{chart, chart};
  EXPECT_EQ(system.cut_by(false).name, "EN 13402-3");  // garments are cut by the chest
  const SizeAnswer none = size_answer(system, body_of({}), 0.5F);
  EXPECT_TRUE(none.entries.empty());
  EXPECT_EQ(none.left_out, std::vector<std::string>{"waist_girth"});
}

// Trousers: the size is right by both, and the reason names the measure that rules the next size out.
TEST(SizeAnswer, WaistAndInsideLegDecideTogether) {
  std::string text = "Size,Waist (in),Inside leg (in)\n";
  for (const int waist : {30, 32, 34, 36})
    for (const int leg : {30, 32, 34})
      text += "W" + std::to_string(waist) + "/L" + std::to_string(leg) + "," + std::to_string(waist) + "," +
              std::to_string(leg) + "\n";
  const SizeChart chart = chart_of(text);
  ASSERT_EQ(chart.rows.size(), 12U);
  const SizeAnswer sure =
      size_answer({chart, chart}, body_of({{"waist_girth", {865, 862, 868}}, {"inside_leg", {860, 857, 863}}}), 0);
  EXPECT_EQ(sure.best, "W34/L34");
  EXPECT_GT(as_map(sure).at("W34/L34"), 0.99);
  // A waist between two sizes, a leg that is sure.
  const SizeAnswer between = size_answer(
      {chart, chart}, body_of({{"waist_girth", {838.2F, 830, 846.4F}}, {"inside_leg", {812, 809, 815}}}), 0);
  const auto p = as_map(between);
  EXPECT_NEAR(p.at("W32/L32"), 0.5, 0.06);
  EXPECT_NEAR(p.at("W34/L32"), 0.5, 0.06);
  ASSERT_TRUE(between.reason);
  EXPECT_EQ(between.reason->sizes[between.reason->best].size, between.best);
  const std::string other = between.reason->sizes[between.reason->other].size;
  EXPECT_TRUE((other == "W32/L32" || other == "W34/L32") && other != between.best) << other;
  EXPECT_EQ(between.reason->region_ids[between.reason->other_region], "waist_girth");
  EXPECT_THAT(size_advice_words(*between.reason), testing::HasSubstr("then " + other + ": its waist girth"));
}

// Cups: the band by the girth under the bust, the letter by the bust.
TEST(SizeAnswer, CupsAreChosenByBustAndUnderBust) {
  const SizeChart chart = chart_of(
      "Size,Underbust (cm),Bust (cm)\n75A,73-77,87-89\n75B,73-77,89-91\n75C,73-77,91-93\n80A,78-82,92-94\n"
      "80B,78-82,94-96\n");
  const SizeAnswer answer = size_answer(
      {chart, chart}, body_of({{"under_bust_girth", {751, 749, 753}}, {"chest_girth", {920, 918, 922}}}), 1);
  EXPECT_EQ(answer.best, "75C");
  // Without the tape the bust alone decides, and the answer says so.
  const SizeAnswer bust = size_answer({chart, chart}, body_of({{"chest_girth", {950, 948, 952}}}), 1);
  EXPECT_EQ(bust.best, "80B");
  EXPECT_EQ(bust.left_out, std::vector<std::string>{"under_bust_girth"});
}

// A shop's chart of several girths by the same rule as garments: a body outside all of it gets no size of it.
TEST(SizeAnswer, WhoIsOutsideAChartOfSeveralGirthsGetsNoSizeOfIt) {
  const SizeChart chart = chart_of("Size,Chest (cm),Waist (cm)\nS,86-94,71-79\nM,94-102,79-87\n");
  EXPECT_EQ(
      size_answer({chart, chart}, body_of({{"chest_girth", {700, 690, 710}}, {"waist_girth", {600, 590, 610}}}), 0)
          .best,
      "<S");
  EXPECT_EQ(size_answer({chart, chart},
                        body_of({{"chest_girth", {1300, 1290, 1310}}, {"waist_girth", {1100, 1090, 1110}}}), 0)
                .best,
            ">M");
}

TEST(SizeChart, SharedChartsOfShopsAreRead) {
  const char* given = std::getenv("IM2FIT_SHARED");
  const std::string root = std::string(given != nullptr ? given : "/nowhere") + "/cases/charts-of-shops/";
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "set IM2FIT_SHARED to the shared folder";
  const std::map<std::string, std::string> best = {{"cm", "M"},         {"desc", "M"},      {"extra_cols", "M"},
                                                   {"hm_single", "46"}, {"inch", "M"},      {"overlap", "L"},
                                                   {"plain", "M"},      {"waist_cols", "M"}};
  for (const auto& [name, size] : best) {
    const auto chart = load_size_chart(root + name + ".csv");
    ASSERT_TRUE(chart) << chart.error().message;
    const auto body = body_of(
        {{"chest_girth", {985, 975, 995}}, {"waist_girth", {840, 830, 850}}, {"hip_girth", {1000, 990, 1010}}});
    EXPECT_EQ(size_answer({*chart, *chart}, body, 0).best, size) << name;
  }
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
