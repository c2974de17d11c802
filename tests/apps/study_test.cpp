// SPDX-License-Identifier: Apache-2.0
// From people to better numbers: simulated sessions, study, calibrate, measure; each program as a shell starts it.
#include <cmath>
#include <filesystem>

#include "depth_folder.h"
#include "measure_run.h"
#include "well_formed.h"

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

double value_of(const json& result, const char* id) {
  return result["measurements"][id]["value"].get<double>();
}

// A camera whose depth is 1.5 % too large shows everybody some 25 mm too tall.
TEST(Study, FromSessionsToACalibrationThatMeasuresBetter) {
  IM2FIT_NEED_DATA();
  test::TestFolder folder;
  const std::string sessions = folder.path("sessions"), site = folder.path("shop.i2c");
  const auto simulated = lab(with_models({"simulate-site", sessions, "--people", "12", "--frames", "5", "--kind",
                                          "camera", "--site", "Shop 3", "--seed", "4"}));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;

  const auto study = lab({"study", sessions, "--json", "--html", folder.path("study.html")});
  ASSERT_EQ(study.exit_code, 0) << study.err;
  const json studied = json::parse(study.out);
  EXPECT_EQ(studied["schema"], "im2fit.study/1");
  EXPECT_GE(studied["people"], 10);
  EXPECT_GT(studied["measurements"]["stature"]["bias"], 15);
  EXPECT_EQ(studied["measurements"]["waist_girth"]["tape"]["pairs"], studied["people"]);
  const std::string html = test::read_text(folder.path("study.html"));
  EXPECT_EQ(test::xml_fault(std::string_view(html).substr(std::string("<!doctype html>\n").size()), {"meta", "br"}),
            "");
  EXPECT_NE(html.find("Shop 3"), std::string::npos);

  const auto learned = lab({"calibrate", sessions, "--out", site, "--json"});
  ASSERT_EQ(learned.exit_code, 0) << learned.err;
  EXPECT_EQ(json::parse(learned.out)["corrects"], "values");

  // Other people before the same camera.
  const Words fresh = {
      "simulate-site", folder.path("fresh"), "--people", "4", "--frames", "5", "--kind", "camera", "--seed", "5",
      "--out"};
  const auto bias = [&](const std::string& out, const Words& more) {
    Words words = with_models(fresh);
    words.insert(std::find(words.begin(), words.end(), "--out") + 1, out);
    words.insert(words.end(), more.begin(), more.end());
    const auto run = lab(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(test::read_text(out))["measurements"]["stature"]["bias"].get<double>();
  };
  const double before = bias(folder.path("before.json"), {});
  const double after = bias(folder.path("after.json"), {"--calibration-site", site});
  EXPECT_LT(std::abs(after), 0.4 * std::abs(before));

  // A clip of a true camera: the program corrects as told, and says so.
  const auto rendered =
      test::run_program({test::kLab, "render", "--out", folder.path("clip"), "--seed", "7", "--subject", "1",
                         "--size", "320x240", "--frames", "20", "--body", test::body_path()});
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  const auto plain = test::measure(folder.path("clip"), folder.path("plain"), {"--frames", "5"});
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  const auto corrected =
      test::measure(folder.path("clip"), folder.path("corrected"), {"--frames", "5", "--calibration-site", site});
  ASSERT_EQ(corrected.exit_code, 0) << corrected.err;
  const json as_answered = json::parse(test::read_text(folder.path("plain/result.json")));
  const json result = json::parse(test::read_text(folder.path("corrected/result.json")));
  EXPECT_FALSE(as_answered.contains("calibration_site"));
  ASSERT_TRUE(result.contains("calibration_site"));
  EXPECT_EQ(result["calibration_site"]["name"], "Shop 3");
  EXPECT_EQ(result["calibration_site"]["uncorrected"]["stature"]["value"], value_of(as_answered, "stature"));
  EXPECT_LT(value_of(result, "stature"), value_of(as_answered, "stature") - 15);
  // One body: the mesh follows.
  EXPECT_NEAR(result["tape"]["stature"]["value"].get<double>(), value_of(result, "stature"), 2);
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
