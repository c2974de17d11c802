// SPDX-License-Identifier: Apache-2.0
// Rendered people measured by the programs: one who turns round, with and without --turn; one who steps round once;
// one in clothes, with
// --clothing, without it, and with a wrong value.
#include "measured_clip.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

namespace im2fit {
namespace {

constexpr int kTurnAfter = 30;
constexpr const char* kFrames = "120";  // 45 of them the turn

class TurnRound : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() { render({"--frames", kFrames, "--turn-after", std::to_string(kTurnAfter)}); }
};

TEST_F(TurnRound, IsMeasuredFromBothSidesWithTheOption) {
  const auto both = measured({"--turn", "--frames", "12"});
  EXPECT_EQ(both["state"], "MEASURED");
  EXPECT_EQ(both["views"], "front+back");
  EXPECT_EQ(both["estimator"], "front+back fit");
  EXPECT_EQ(both["frames"]["used"], 24);
  EXPECT_EQ(both["guidance"], nlohmann::json::array());
  const auto front = measured({"--frames", "12"});
  EXPECT_EQ(front["views"], "front");
  EXPECT_EQ(front["estimator"], "front fit");
  EXPECT_EQ(front["frames"]["used"], 12);
  EXPECT_LT(front["frames"]["seen"], kTurnAfter);
}

TEST_F(TurnRound, LiveAsksForItAndTellsTheStates) {
  const test::Run run = test::run_program({test::kProgram, "live", clip(), "--turn", "--json", "--count", "1",
                                           "--frames", "12", "--body", test::body_path(), "--tracker",
                                           test::tracker_path(), "--index", test::index_path()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  std::vector<std::string> states;
  bool requested = false;
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) {
    const auto event = nlohmann::json::parse(line, nullptr, false);
    ASSERT_TRUE(event.is_object()) << line;
    if (event["event"] == "measured") {
      EXPECT_EQ(event["result"]["views"], "front+back");
    }
    if (event["event"] != "state") continue;
    if (states.empty() || states.back() != event["state"]) states.push_back(event["state"]);
    const auto& codes = event["guidance"];
    const bool now = std::find(codes.begin(), codes.end(), "TURN_ROUND") != codes.end();
    EXPECT_FALSE(now && event["state"] != "TURNING") << line;
    requested = requested || now;
  }
  EXPECT_TRUE(requested);
  ASSERT_GE(states.size(), 2U);
  EXPECT_EQ(states.back(), "MEASURED");
  EXPECT_EQ(states[states.size() - 2], "TURNING");
}

class StepsRound : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() { render({"--frames", "330", "--step-round-after", "30", "--pose", "arms_out"}); }
};

// 30 mm: a third of what a front leaves open. How well it measures: docs/evaluation-results.md.
TEST_F(StepsRound, IsMeasuredAllRoundWithTheOption) {
  const auto around = measured({"--around", "--frames", "12"});
  EXPECT_EQ(around["views"], "around");
  EXPECT_EQ(around["estimator"], "around fit");
  EXPECT_GE(std::abs(around["turned_deg"].get<double>()), 330);
  EXPECT_EQ(around["guidance"], nlohmann::json::array());
  EXPECT_GT(around["frames"]["used"], 12 + 60) << "ten pictures a second of the turn";
  const auto front = measured({"--frames", "12"});
  EXPECT_EQ(front["views"], "front");
  EXPECT_FALSE(front.contains("turned_deg"));
  const auto truth = nlohmann::json::parse(test::read_text(clip() + "/truth.json"), nullptr, false)["measurements"];
  for (const char* girth : {"chest_girth", "waist_girth", "hip_girth"}) {
    const auto& of = around["measurements"][girth];
    EXPECT_LT(std::abs(of["value"].get<double>() - truth[girth]["value"].get<double>()), 30) << girth;
    const auto width = [&](const auto& result) {
      const auto& interval = result["measurements"][girth]["interval"];
      return interval[1].template get<double>() - interval[0].template get<double>();
    };
    EXPECT_LT(width(around), 0.75 * width(front)) << girth;
  }
}

// The person of `synthetic` stands, and the camera is carried round, its poses told.
TEST(CarriedRound, IsMeasuredAllRound) {
  if (!test::have_data()) GTEST_SKIP() << "no models: scripts/test makes them";
  std::string on_two;
  for (const char* threads : {"2", "1"}) {
    const test::Run run = test::run_program({test::kProgram, "measure", "synthetic:7", "--around=camera", "--json",
                                             "--frames", "12", "--threads", threads, "--body", test::body_path(),
                                             "--tracker", test::tracker_path(), "--index", test::index_path()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto result = nlohmann::json::parse(run.out, nullptr, false);
    ASSERT_FALSE(result.is_discarded()) << run.out;
    EXPECT_EQ(result["views"], "around");
    EXPECT_GE(std::abs(result["turned_deg"].get<double>()), 330);
    EXPECT_EQ(result["guidance"], nlohmann::json::array());
    if (on_two.empty()) on_two = run.out;
    EXPECT_EQ(run.out, on_two) << "on one thread as on two";
  }
}

TEST_F(StepsRound, GivesTheSameBytesOnOneThread) {
  EXPECT_EQ(measured({"--around", "--frames", "12", "--threads", "1"}).dump(),
            measured({"--around", "--frames", "12", "--threads", "2"}).dump());
}

TEST_F(StepsRound, WhoTurnsTooLittleIsMeasuredFromTheFrontAndToldSo) {
  // The recording ends a second into the turn.
  const test::TestFolder part;
  for (const auto& file : std::filesystem::recursive_directory_iterator(clip())) {
    if (!file.is_regular_file()) continue;
    const auto name = std::filesystem::relative(file.path(), clip());
    if (name.extension() == ".png" && name.stem().string() > "000060") continue;
    std::filesystem::create_directories(std::filesystem::path(part.path(name.string())).parent_path());
    std::filesystem::copy_file(file.path(), part.path(name.string()));
  }
  const test::Run run =
      test::run_program({test::kProgram, "measure", part.path(""), "--around", "--json", "--frames", "12", "--body",
                         test::body_path(), "--tracker", test::tracker_path(), "--index", test::index_path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto result = nlohmann::json::parse(run.out, nullptr, false);
  EXPECT_EQ(result["views"], "front");
  EXPECT_EQ(result["guidance"], nlohmann::json::array({"TURN_ON"}));
  EXPECT_NE(run.err.find("measured from the front alone: the person turned by"), std::string::npos) << run.err;
}

class InClothes : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() { render({"--frames", "20", "--clothed"}); }
};

// Told: the body underneath. Not told: the surface seen, with intervals that reach the body underneath.
TEST_F(InClothes, TheBodyUnderneathIsInTheIntervalsWhateverIsSaid) {
  const auto told = measured({"--clothing", "dressed", "--frames", "12"});
  const auto untold = measured({"--frames", "12"});
  const auto denied = measured({"--clothing", "bare", "--frames", "12"});
  const auto truth = nlohmann::json::parse(test::read_text(clip() + "/truth.json"), nullptr, false)["measurements"];
  for (const auto& result : {told, untold, denied}) {
    EXPECT_GT(result["clothing"]["probability"].get<double>(), 0.9);
    // Everyday clothes stand off by 4 to 20 mm.
    EXPECT_GT(result["clothing"]["ease_mm"].get<double>(), 2);
    EXPECT_LT(result["clothing"]["ease_mm"].get<double>(), 30);
    for (const char* girth : {"chest_girth", "waist_girth", "hip_girth"}) {
      const auto& under = result["measurements"][girth];
      EXPECT_LE(under["interval"][0].get<double>(), truth[girth]["value"].get<double>()) << girth;
      EXPECT_GE(under["interval"][1].get<double>(), truth[girth]["value"].get<double>()) << girth;
      EXPECT_GT(under["interval"][1].get<double>() - under["interval"][0].get<double>(), 60)
          << girth << ": the interval says so";
    }
  }
  for (const char* girth : {"chest_girth", "waist_girth", "hip_girth"})
    EXPECT_LT(std::abs(told["measurements"][girth]["value"].get<double>() - truth[girth]["value"].get<double>()), 80)
        << girth;
  EXPECT_EQ(told["clothing"]["answered_as"], "dressed");
  EXPECT_EQ(untold["clothing"]["answered_as"], "bare");
  EXPECT_EQ(denied["clothing"]["answered_as"], "bare");
  EXPECT_EQ(untold["measurements"]["waist_girth"]["value"], denied["measurements"]["waist_girth"]["value"])
      << "an estimate of clothes shifts no value";
  EXPECT_TRUE(told["guidance"].empty());
  EXPECT_TRUE(untold["guidance"].empty());
  EXPECT_EQ(denied["guidance"], nlohmann::json::array({"CLOTHED"})) << "said to be bare, and seen dressed";
}

}  // namespace
}  // namespace im2fit
