// SPDX-License-Identifier: Apache-2.0
// `im2fit-lab eval --tracker` as a shell starts it.
#include <iterator>
#include <sstream>

#include "measure_run.h"

namespace im2fit {
namespace {

using Words = std::vector<std::string>;

test::Run eval(const Words& words) {
  Words command = {test::kLab, "eval", "--body", test::body_path(), "--joint-model", test::tracker_path()};
  command.insert(command.end(), words.begin(), words.end());
  test::RunOptions options;
  options.timeout_s = 300;
  return test::run_program(command, options);
}

Words words_of(const std::string& line) {
  std::istringstream in(line);
  return {std::istream_iterator<std::string>(in), {}};
}

TEST(TrackerEval, WrongWordsExitWithTwoAndOneLine) {
  const Words table[] = {
      {"--tracker", "file.i2t"},
      {"--tracker", "--only", "knees"},
      {"--tracker", "--scenes", "foggy"},
      {"--tracker", "--clips", "0"},
      {"--tracker", "--clip-frames", "5"},
      {"--tracker", "--empty-frames", "-1"},
      {"--tracker", "--guidance-scenes", "some"},
      {"--tracker", "--pictures"},
      {"--tracker", "--condition", "bare"},
      {"--tracker", "--index", "x.i2f"},
      {"--tracker", "--frames", "30"},
      {"--only", "joints"},
      {"--scenes", "full"},
      {"--pictures", "x"},
  };
  for (const Words& words : table) {
    std::string joined;
    for (const std::string& word : words) joined += word + " ";
    SCOPED_TRACE(joined);
    const test::Run run = eval(words);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
  }
}

TEST(TrackerEval, NeedsItsFiles) {
  const test::TestFolder folder;
  const test::Run run =
      test::run_program({test::kLab, "eval", "--tracker", "--body", folder.path("no.i2b"), "--subjects", "1"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
}

// One of everything, on one thread and on three.
TEST(TrackerEval, DoesNotDependOnTheNumberOfThreads) {
  IM2FIT_NEED_TRACKER();
  const test::TestFolder folder;
  const Words tiny = words_of(
      "--tracker --subjects 2 --scenes-per-subject 1 --clips 1 --clip-frames 25 --empty-frames 25 --guidance-scenes "
      "1 "
      "--scenes full,OK,NOT_UPRIGHT --seed 7 --json");
  Words alone = tiny, together = tiny;
  alone.insert(alone.end(), {"--threads", "1", "--out", folder.path("alone.json")});
  together.insert(together.end(), {"--threads", "3", "--pictures", folder.path("sheets")});
  const test::Run one = eval(alone);
  const test::Run three = eval(together);
  ASSERT_EQ(one.exit_code, 0) << one.err;
  ASSERT_EQ(three.exit_code, 0) << three.err;
  EXPECT_EQ(one.out, three.out);
  EXPECT_EQ(one.out, test::read_text(folder.path("alone.json")));
  const auto json = nlohmann::json::parse(one.out, nullptr, false);
  ASSERT_TRUE(json.is_object()) << one.out;
  EXPECT_EQ(json.at("schema"), "im2fit.tracker-evaluation/1");
  EXPECT_EQ(json.at("data"), "synthetic");
  // 2 people before 2 cameras.
  EXPECT_EQ(json.at("joints").at(0).at("converged").at("frames"), 4);
  EXPECT_EQ(json.at("segmentation").at(0).at("converged").at("frames"), 4);
  EXPECT_EQ(json.at("empty").at("frames"), 25);
  EXPECT_EQ(json.at("people").at("frames"), 25);
  EXPECT_EQ(json.at("guidance").size(), 2U);
  for (const char* sheet : {"worst.png", "random.png", "guidance.png"})
    EXPECT_EQ(test::read_text(folder.path(std::string("sheets/") + sheet)).substr(1, 3), "PNG") << sheet;
}

TEST(TrackerEval, JudgesOnlyWhatIsGiven) {
  IM2FIT_NEED_TRACKER();
  const test::Run run = eval(words_of("--tracker --only guidance --scenes OK,NO_PERSON --guidance-scenes 1 --json"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(json.is_object()) << run.out;
  EXPECT_FALSE(json.contains("joints"));
  ASSERT_EQ(json.at("guidance").size(), 2U);
  EXPECT_EQ(json.at("guidance").at(0).at("kind"), "OK");
  EXPECT_EQ(json.at("guidance").at(1).at("scenes"), 1);
}

}  // namespace
}  // namespace im2fit
