// SPDX-License-Identifier: Apache-2.0
// live over a recording of two people who come one after the other: events, files, pictures, the terminal.
#include <algorithm>
#include <sstream>

#include "measure_run.h"
#include "two_people.h"

namespace im2fit {
namespace {

// No person, two people apart, made once.
class Live : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!test::have_data()) return;
    folder_ = new test::TestFolder;
    test::write_two_people(folder_->path("two"));
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  void SetUp() override {
    if (folder_ == nullptr) GTEST_SKIP() << "no body, tracker or index file";
  }
  static test::Run live(std::vector<std::string> words) {
    std::vector<std::string> command = {test::kProgram,
                                        "live",
                                        folder_->path("two"),
                                        "--frames",
                                        "5",
                                        "--body",
                                        test::body_path(),
                                        "--tracker",
                                        test::tracker_path(),
                                        "--index",
                                        test::index_path()};
    command.insert(command.end(), words.begin(), words.end());
    return test::run_program(command);
  }
  static std::vector<nlohmann::json> events(const std::string& text) {
    std::vector<nlohmann::json> all;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_TRUE(nlohmann::json::accept(line)) << line;
      all.push_back(nlohmann::json::parse(line, nullptr, false));
    }
    return all;
  }
  static inline test::TestFolder* folder_ = nullptr;
};

TEST_F(Live, EveryPersonsResultIsTheSameOnOneThreadAndTwo) {
  for (const char* threads : {"1", "2"})
    ASSERT_EQ(live({"--threads", threads, "--out", folder_->path(std::string("threads-") + threads)}).exit_code, 0);
  for (const char* file :
       {"/person-001/result.json", "/person-002/result.json", "/person-001/overlay.png", "/person-002/overlay.png"}) {
    const std::string one = test::read_text(folder_->path("threads-1") + file);
    EXPECT_GT(one.size(), 1000U);
    EXPECT_TRUE(one == test::read_text(folder_->path("threads-2") + file)) << file;
  }
}

TEST_F(Live, MeasuresOnePersonAfterTheOtherAndTellsItLineByLine) {
  const std::string out = folder_->path("out");
  const test::Run run = live({"--json", "--out", out});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  std::vector<std::string> story;
  std::vector<std::string> states;
  for (const auto& event : events(run.out)) {
    if (event["event"] == "state")
      states.push_back(event["state"]);
    else
      story.push_back(event["event"]);
    if (event["event"] != "measured") continue;
    EXPECT_EQ(event["result"]["state"], "MEASURED");
    EXPECT_EQ(event["result"]["frames"]["used"], 5);
    EXPECT_EQ(event["result"],
              nlohmann::json::parse(test::read_text(event["out"].get<std::string>() + "/result.json")));
  }
  EXPECT_EQ(story, (std::vector<std::string>{"measured", "left", "measured", "end"}));
  EXPECT_EQ(std::count(states.begin(), states.end(), "LOST"), 0);
  for (const char* person : {"/person-001", "/person-002"}) {
    EXPECT_TRUE(test::partial_files_in(out + person).empty()) << person;
    EXPECT_EQ(test::files_in(out + person).size(), 7U);
  }
}

TEST_F(Live, CountEndsItAndOneNeedsNoFolderOfItsOwn) {
  const std::string out = folder_->path("one");
  const test::Run run = live({"--count", "1", "--out", out});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(std::filesystem::exists(out + "/result.json"));
  EXPECT_NE(run.out.find("person 1"), std::string::npos);
  EXPECT_EQ(run.out.find("person 2"), std::string::npos);
}

TEST_F(Live, DrawsTheRequestedPictures) {
  const std::string pictures = folder_->path("pictures");
  const test::Run run = live({"--overlay", pictures, "--overlay-every", "3", "--count", "1", "--threads", "1"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  std::vector<std::string> names = test::files_in(pictures);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"000000.png", "000003.png"})) << "five frames were processed";
  EXPECT_TRUE(test::partial_files_in(pictures).empty());
}

TEST_F(Live, ShowsItselfInTheTerminalAndLeavesItAsItWas) {
  const test::Run run = live({"--view", "--count", "1"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("\u2580"), std::string::npos);
  EXPECT_NE(run.err.find("TRACKING"), std::string::npos);
  const std::size_t enter = run.err.find("\033[?1049h");
  const std::size_t leave = run.err.find("\033[?1049l");
  ASSERT_NE(enter, std::string::npos);
  ASSERT_NE(leave, std::string::npos);
  EXPECT_LT(enter, leave);
  EXPECT_EQ(run.err.find("\u2580", leave), std::string::npos);
  EXPECT_NE(run.out.find("stature"), std::string::npos);
}

TEST_F(Live, NoPersonMeasuredIsExitCodeThreeWithTheGuidance) {
  const std::string out = folder_->path("no-person");
  const test::Run run = live({"--json", "--user", "77", "--out", out});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  const auto all = events(run.out);
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(all.back()["event"], "end");
  EXPECT_EQ(all.back()["persons"], 0);
  EXPECT_EQ(all.back()["result"]["guidance"], nlohmann::json::array({"NO_PERSON"}));
  EXPECT_TRUE(std::filesystem::exists(out + "/result.json"));
}

TEST_F(Live, UsersAreNumbers) {
  for (const char* word : {"bob", "0", "-1", "1x", ""}) {
    const test::Run run = live({"--user", word});
    EXPECT_EQ(run.exit_code, 2) << word;
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  }
}

}  // namespace
}  // namespace im2fit
