// SPDX-License-Identifier: Apache-2.0
// Simulated sessions, study and calibrate, each program as a shell starts it. The whole loop from people to better
// numbers is in tests/apps/serve/round_trip_test.cpp.
#include <algorithm>
#include <filesystem>
#include <functional>

#include "depth_folder.h"
#include "measure_run.h"

namespace im2fit {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

test::Run lab(const Words& words) {
  Words command = {test::kLab};
  command.insert(command.end(), words.begin(), words.end());
  test::RunOptions options;
  options.timeout_s = 300;
  return test::run_program(command, options);
}

Words with_models(Words words) {
  for (const std::string& word : {std::string("--body"), test::body_path(), std::string("--joint-model"),
                                  test::tracker_path(), std::string("--index"), test::index_path()})
    words.push_back(word);
  return words;
}

TEST(Study, SimulatedPeopleAreSessionsThatCanBeStudied) {
  IM2FIT_NEED_DATA();
  test::TestFolder folder;
  const std::string sessions = folder.path("sessions");
  const auto simulated = lab(with_models({"simulate-site", sessions, "--people", "3", "--frames", "5", "--kind",
                                          "camera", "--site", "Shop 3", "--seed", "4"}));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const auto study = lab({"study", sessions, "--json"});
  ASSERT_EQ(study.exit_code, 0) << study.err;
  const json studied = json::parse(study.out);
  EXPECT_EQ(studied["schema"], "im2fit.study/1");
  EXPECT_GE(studied["people"], 2);
  // A camera whose depth is 1.5 % too large shows everybody some 25 mm too tall.
  EXPECT_GT(studied["measurements"]["stature"]["bias"], 15);
  const auto learned = lab({"calibrate", sessions, "--out", folder.path("shop.i2c")});
  EXPECT_EQ(learned.exit_code, 1) << "too few people";
  EXPECT_NE(learned.out.find("people with tape values are too few"), std::string::npos) << learned.out;
}

// One answer of 1e30 mm outweighs everybody else's.
TEST(Study, AnAbsurdAnswerIsLeftOutByName) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const std::string root = folder.path("sessions");
  const auto simulated =
      lab(with_models({"simulate-site", root, "--people", "8", "--frames", "5", "--kind", "camera", "--seed", "4"}));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  std::vector<std::string> sessions = test::files_in(root);
  std::sort(sessions.begin(), sessions.end());
  ASSERT_GE(sessions.size(), 6U);
  const std::pair<std::function<void(json&)>, std::string> kFaults[] = {
      {[](json& j) { j["measurements"]["chest_girth"]["value"] = 1e30; },
       "result.json: chest_girth has 1e+30, expected 10 to 3000"},
      {[](json& j) { j["measurements"]["weight"]["interval"][1] = 1e300; },
       "result.json: weight has 1e+300, expected 10 to 400"},
      {[](json& j) {
         j["measurements"]["hip_girth"]["interval"] = {1200, 900};
       },
       "result.json: the interval of hip_girth is reversed: 1200 to 900"},
      {[](json& j) { j["sex"]["female"] = -7; }, "result.json: sex.female is -7, expected 0 to 1"},
      {[](json& j) { j["state"] = "\x1b[2J" + std::string(1000, 'x'); }, "not measured:  [2Jxxx"}};
  std::size_t number = 0;
  for (const auto& [spoil, why] : kFaults) {
    const std::string path = root + "/" + sessions[number++] + "/result.json";
    json result = json::parse(test::read_text(path));
    spoil(result);
    test::write_text(path, result.dump());
  }
  const auto study = lab({"study", root, "--json"});
  ASSERT_EQ(study.exit_code, 0) << study.err;
  EXPECT_EQ(json::parse(study.out)["people"], sessions.size() - std::size(kFaults));
  for (std::size_t i = 0; i < std::size(kFaults); ++i)
    EXPECT_NE(study.err.find("study: left out " + sessions[i] + ": " + kFaults[i].second), std::string::npos)
        << kFaults[i].second << "\n"
        << study.err;
  EXPECT_EQ(study.err.find('\x1b'), std::string::npos);
}

TEST(Study, WhatCannotBeSaysWhy) {
  test::TestFolder folder;
  std::filesystem::create_directories(folder.path("empty"));
  for (const char* command : {"study", "calibrate"}) {
    Words words = {command, folder.path("empty")};
    if (std::string(command) == "calibrate") words.insert(words.end(), {"--out", folder.path("x.i2c")});
    const auto run = lab(words);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
    EXPECT_NE(run.err.find("no sessions"), std::string::npos) << run.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("x.i2c")));
  EXPECT_EQ(lab({"simulate-site", "--kind", "moon"}).exit_code, 2);
  EXPECT_EQ(lab({"simulate-site", "--trials", "2", "--html", "x.html"}).exit_code, 2);
}

}  // namespace
}  // namespace im2fit
