// SPDX-License-Identifier: Apache-2.0
// Simulated sessions, study and calibrate, each program as a shell starts it. The whole loop from people to better
// numbers is in tests/apps/serve/round_trip_test.cpp.
#include <filesystem>

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
