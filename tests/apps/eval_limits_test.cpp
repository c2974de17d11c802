// SPDX-License-Identifier: Apache-2.0
// `im2fit-lab eval-limits`: two people in each situation, with the small models of the tests. A row that breaks in
// the engine or in the scenes fails here; how many of a hundred are right is in docs/notebook/limits.md.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "measure_run.h"

namespace im2fit {
namespace {

using Words = std::vector<std::string>;

test::Run eval_limits(const Words& words) {
  Words command = {test::kLab,      "eval-limits",        "--body",  test::body_path(),
                   "--joint-model", test::tracker_path(), "--index", test::index_path()};
  if (std::find(words.begin(), words.end(), "--family") == words.end())
    command.insert(command.end(), {"--family", "modifiers"});
  command.insert(command.end(), words.begin(), words.end());
  test::RunOptions options;
  options.timeout_s = 300;
  return test::run_program(command, options);
}

// Cells of the rows, by situation.
std::map<std::string, std::vector<std::map<std::string, std::string>>> rows_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line, cell;
  std::vector<std::string> head;
  std::map<std::string, std::vector<std::map<std::string, std::string>>> rows;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    for (std::istringstream in(line + ","); std::getline(in, cell, ',');) cells.push_back(cell);
    if (head.empty()) {
      head = cells;
      continue;
    }
    std::map<std::string, std::string> row;
    for (std::size_t i = 0; i < head.size() && i < cells.size(); ++i) row[head[i]] = cells[i];
    rows[row["situation"]].push_back(row);
  }
  return rows;
}

TEST(EvalLimits, EverySituationIsRefusedByNameOrRight) {
  if (!test::have_data()) GTEST_SKIP() << "no body, tracker or index file";
  const test::TestFolder folder;
  const test::Run run = eval_limits({"--subjects", "2", "--people", folder.path("people.csv")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  auto rows = rows_of(test::read_text(folder.path("people.csv")));
  const std::map<std::string, std::string> codes = {{"ordinary", ""},
                                                    {"dressed", ""},
                                                    {"child", "OUT_OF_POPULATION"},
                                                    {"tall", "OUT_OF_POPULATION"},
                                                    {"squat", "NOT_UPRIGHT"},
                                                    {"range", "FLOOR_BENT"},
                                                    {"lens", "FLOOR_BENT"},
                                                    {"scale", "FEET_RAISED"},
                                                    {"platform", "FEET_RAISED"},
                                                    {"heels", "FEET_RAISED"},
                                                    {"crown", "HEAD_UNSEEN"}};
  ASSERT_EQ(rows.size(), 14U);
  for (auto& [situation, people] : rows) {
    ASSERT_EQ(people.size(), 2U) << situation;
    int right = 0;
    for (auto& person : people) {
      right += person["right"] == "1" ? 1 : 0;
      if (person["right"] == "1" && codes.contains(situation)) {
        EXPECT_EQ(person["unexpected"], codes.at(situation)) << situation;
      }
    }
    EXPECT_EQ(right, situation == "child" ? 1 : 2) << situation << ": the small tracker does not find one child\n"
                                                   << run.out;
    EXPECT_THAT(run.out, testing::HasSubstr("| " + situation + ": "));
  }
  EXPECT_THAT(run.out, testing::HasSubstr("| all but the ordinary | 23 of 24 (95.8 %) |"));
}

TEST(EvalLimits, WrongWordsExitWithTwoAndOneLine) {
  for (const Words& words : {Words{"--situations", "upside-down"}, {"--subjects", "0"}, {"--family", "twins"}}) {
    const test::Run run = eval_limits(words);
    EXPECT_EQ(run.exit_code, 2) << words.back();
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
  }
}

TEST(EvalLimits, SituationsThatAFamilyCannotShowAreRefusedByName) {
  const test::Run run = eval_limits({"--family", "other", "--situations", "heels"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
  EXPECT_THAT(run.err, testing::HasSubstr("cannot be shown in the situation heels; choose another family"));
}

TEST(EvalLimits, PicturesAreWrittenOfThoseAskedFor) {
  if (!test::have_data()) GTEST_SKIP() << "no body, tracker or index file";
  const test::TestFolder folder;
  const test::Run run =
      eval_limits({"--subjects", "1", "--situations", "hem,heels", "--pictures", folder.path("pictures")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(test::read_text(folder.path("pictures/hem-0.png")).substr(1, 3), "PNG");
  EXPECT_EQ(test::read_text(folder.path("pictures/heels-0.png")).substr(1, 3), "PNG");
}

}  // namespace
}  // namespace im2fit
