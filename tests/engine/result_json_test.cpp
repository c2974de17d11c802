// SPDX-License-Identifier: Apache-2.0
#include "report/result_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "fake_stages.h"
#include "schema.h"

namespace im2fit {
namespace {

using nlohmann::json;

json schema() {
  std::ifstream in(IM2FIT_RESULT_SCHEMA);
  return json::parse(in);
}

const std::vector<std::string> kModifiers = {"torso/scale", "hip/scale"};

PersonMeasurement measured_report() {
  PersonMeasurement report;
  EngineResult& r = report.result;
  r.state = SessionState::measured;
  r.measured = true;
  r.views = AnswerViews::front;
  r.frames_seen = 60;
  r.frames_used = 30;
  r.guidance_frames[3] = 50;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const float value = 1000.06F + 100 * static_cast<float>(i);
    r.answer.measurements[i] = {value, value - 12.34F, value + 12.34F};
    r.paper[i] = i < 9 ? value + 1 : std::numeric_limits<float>::quiet_NaN();
  }
  r.answer.measurements[measurement_index(Measurement::weight)] = {71.236F, 65.0F, 77.119F};
  r.answer.female = 0.03F;
  r.age = {{41.04F, 19.96F, 71.5F}, {0.125F, 0.5F, 0.25F, 0.125F}};
  r.answer.nearest = 1234;
  r.answer.nearest_distance = 1.25F;
  r.measured_joints = test::standing_joints(false);
  r.measured_joints[Joint::HE] = {-0.04F, -700.25F, 2000.06F};
  report.source.uri = "folder:/data/\"one\"";
  report.source.name = "folder";
  report.source.intrinsics = {480, 640, 575.8F, 575.8F, 239.5F, 319.5F};
  report.source.intrinsics_origin = hal::IntrinsicsOrigin::calibration_file;
  report.source.rotate_deg = 90;
  report.size = size_probabilities(builtin_size_system(), {1000, 980, 1020}, 0.03F);
  body::Params params;
  params.modifiers = {0.5F, 0.0F};
  params.warp[body::WarpValue::waist_front] = -0.0123456F;
  report.body.emplace();
  report.body->params = params;
  report.body->fit.residual[measurement_index(Measurement::waist_girth)] = 0.126F;
  report.body->fit.residual[measurement_index(Measurement::weight)] = -0.0126F;
  report.modifier_names = kModifiers;
  return report;
}

bool has_code(const json& result, const char* code) {
  const json& codes = result["guidance"];
  return std::find(codes.begin(), codes.end(), code) != codes.end();
}

TEST(ResultJson, AMeasuredResultMeetsTheSchema) {
  const json value = json::parse(result_json(measured_report()));
  EXPECT_THAT(test::SchemaCheck(schema()).run(value), testing::IsEmpty());
}

TEST(ResultJson, TheTapeIsOfTheBodyAndLeavesOutWhatIsRefused) {
  body::Tape tape;
  tape.definitions.resize(4);
  tape.definitions[0].id = "weight";
  tape.definitions[0].value = Measurement::weight;
  tape.definitions[1].id = "knee_girth";
  tape.definitions[1].kind = body::TapeKind::girth;
  tape.definitions[1].iso_8559 = "5.3.22";
  tape.definitions[2].id = "head_girth";
  tape.definitions[2].kind = body::TapeKind::refused;
  tape.definitions[3].id = "boot";
  tape.definitions[3].kind = body::TapeKind::girth;
  PersonMeasurement report = measured_report();
  report.tape = &tape;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  report.tape_values = {71.236F, 380.06F, kNan, kNan};
  const json v = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
  EXPECT_EQ(v["tape"], json({{"weight", {{"value", 71.24}, {"unit", "kg"}, {"iso", nullptr}}},
                             {"knee_girth", {{"value", 380.1}, {"unit", "mm"}, {"iso", "ISO 8559-1:2017 5.3.22"}}},
                             {"boot", {{"value", nullptr}, {"unit", "mm"}, {"iso", nullptr}}}}));
  report.tape_intervals = {{true, 65, 77.118F}, {true, 350.04F, 410}, {}, {}};
  const json with = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(with), testing::IsEmpty());
  EXPECT_EQ(with["tape"]["weight"]["interval"], json({65.0, 77.12}));
  EXPECT_EQ(with["tape"]["knee_girth"]["interval"], json({350.0, 410.0}));
  EXPECT_FALSE(with["tape"]["boot"].contains("interval"));
  report.body.reset();
  EXPECT_FALSE(json::parse(result_json(report)).contains("tape"));
}

TEST(ResultJson, SaysWhatTheResultSays) {
  const json v = json::parse(result_json(measured_report()));
  EXPECT_EQ(v["schema"], "im2fit.result/1");
  EXPECT_EQ(v["state"], "MEASURED");
  EXPECT_EQ(v["guidance"], json::array()) << "once measured nothing is needed";
  EXPECT_EQ(v["frames"], json({{"seen", 60}, {"used", 30}, {"dropped", 0}, {"damaged", 0}}));
  EXPECT_EQ(v["source"]["uri"], "folder:/data/\"one\"");
  EXPECT_EQ(v["source"]["intrinsics"]["origin"], "calibration_file");
  EXPECT_EQ(v["source"]["intrinsics"]["fx"], 575.8);
  EXPECT_EQ(v["source"]["rotate_deg"], 90);
  ASSERT_EQ(v["measurements"].size(), kMeasurementCount);
  EXPECT_EQ(v["measurements"]["stature"]["value"], 1000.1);
  EXPECT_EQ(v["measurements"]["stature"]["interval"], json::array({987.7, 1012.4}));
  EXPECT_EQ(v["measurements"]["stature"]["unit"], "mm");
  EXPECT_EQ(v["measurements"]["stature"]["iso"], "ISO 8559-1:2017 5.1.1");
  EXPECT_EQ(v["measurements"]["shoulder_girth"]["iso"], nullptr);
  EXPECT_EQ(v["measurements"]["weight"]["value"], 71.24);
  EXPECT_EQ(v["measurements"]["weight"]["interval"], json::array({65.0, 77.12}));
  EXPECT_EQ(v["measurements"]["weight"]["unit"], "kg");
  EXPECT_EQ(v["sex"]["female"], 0.03);
  EXPECT_EQ(v["age"]["value"], 41.0);
  EXPECT_EQ(v["age"]["interval"], json::array({20.0, 71.5}));
  EXPECT_EQ(v["age"]["bands"]["25-45"], 0.5);
  EXPECT_EQ(v["size"]["chart"], "EN 13402-3");
  EXPECT_EQ(v["size"]["best"], "M");
  EXPECT_EQ(v["joints"].size(), kJointCount);
  EXPECT_EQ(v["joints"]["HE"]["position_mm"], json::array({0.0, -700.2, 2000.1}));
  EXPECT_EQ(v["joints"]["HE"]["confidence"], 0.9);
  EXPECT_EQ(v["body"]["entry"], 1234);
  EXPECT_EQ(v["body"]["distance"], 1.25);
  EXPECT_EQ(v["body"]["parameters"]["modifiers"], json({{"torso/scale", 0.5}}));
  EXPECT_EQ(v["body"]["parameters"]["warp"], json({{"waist_front", -0.012346}}));
  EXPECT_EQ(v["body"]["residual_mm"].size(), kMeasurementCount - 1);
  EXPECT_EQ(v["body"]["residual_mm"]["waist_girth"], 0.13);
  EXPECT_EQ(v["body"]["residual_kg"], -0.013);
  EXPECT_EQ(v["body"]["meets_measurements"], true);
  EXPECT_EQ(v["paper"].size(), 9U) << "what the paper does not measure is left out";
  EXPECT_EQ(v["paper"]["stature"], 1001.1);
  EXPECT_FALSE(v.contains("timing"));
}

// Lengths may be off by more; a girth off by 2 mm is reported.
TEST(ResultJson, AChartOfSeveralMeasurementsGivesItsReason) {
  PersonMeasurement person = measured_report();
  const auto chart =
      parse_size_chart("Size,Chest (cm),Waist (cm),Knee (cm)\nS,86-94,71-79,36\nM,94-102,79-87,38\n", "c");
  ASSERT_TRUE(chart) << chart.error().message;
  const auto lookup = [](std::string_view id) {
    return id == "knee_girth" ? std::optional<index::IntervalEstimate>()
                              : index::IntervalEstimate{id == "chest_girth" ? 980.0F : 780.0F, 770, 790};
  };
  person.size = size_answer({*chart, *chart}, lookup, 0);
  const json v = json::parse(result_json(person));
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
  EXPECT_EQ(v["size"]["best"], "M");
  EXPECT_EQ(v["size"]["reason"]["other"]["size"], "S");
  EXPECT_EQ(v["size"]["reason"]["other"]["region"], "chest_girth");
  EXPECT_EQ(v["size"]["reason"]["sizes"]["M"]["waist_girth"]["ease_mm"], 50.0);
  EXPECT_EQ(v["size"]["left_out"], json({"knee_girth"}));
}

TEST(ResultJson, ABodyThatMeasuresSomethingElseIsSaidToDoSo) {
  PersonMeasurement report = measured_report();
  report.body->fit.residual[measurement_index(Measurement::inside_leg)] = 5;
  EXPECT_EQ(json::parse(result_json(report))["body"]["meets_measurements"], true);
  report.body->fit.residual[measurement_index(Measurement::hip_girth)] = -2.1F;
  EXPECT_EQ(json::parse(result_json(report))["body"]["meets_measurements"], false);
}

TEST(ResultJson, NamesTheSidesBehindTheAnswer) {
  PersonMeasurement report = measured_report();
  EXPECT_EQ(json::parse(result_json(report))["views"], "front");
  report.result.views = AnswerViews::front_and_back;
  const json both = json::parse(result_json(report));
  EXPECT_EQ(both["views"], "front+back");
  EXPECT_THAT(test::SchemaCheck(schema()).run(both), testing::IsEmpty());

  report.result.measured = false;
  report.result.front_measured = true;
  report.result.state = SessionState::turning;
  report.result.guidance = static_cast<GuidanceSet>(Guidance::turn_round);
  const json turning = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(turning), testing::IsEmpty());
  EXPECT_EQ(turning["state"], "TURNING");
  EXPECT_TRUE(has_code(turning, "TURN_ROUND"));
  EXPECT_FALSE(turning.contains("views")) << "a preliminary answer is not reported";
  EXPECT_TRUE(turning["measurements"].empty());
}

TEST(ResultJson, ACorrectedAnswerNamesItsSiteAndWhatItWasBefore) {
  PersonMeasurement report = measured_report();
  SiteCalibration site;
  site.name = "Shop 3";
  site.people = 21;
  site.crc32c = 0x0123ABCD;
  site.cameras.push_back({"folder", 1.01});
  report.site = &site;
  report.result.uncorrected = report.result.answer.measurements;
  report.result.answer.measurements[0] = {1010, 1000, 1020};
  const json j = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(j), testing::IsEmpty());
  const json& said = j["calibration_site"];
  EXPECT_EQ(said["name"], "Shop 3");
  EXPECT_EQ(said["people"], 21);
  EXPECT_EQ(said["crc32c"], "0123abcd");
  EXPECT_EQ(said["camera_known"], true);
  EXPECT_EQ(said["index_known"], nullptr);
  EXPECT_EQ(j["measurements"]["stature"]["value"], 1010);
  EXPECT_EQ(said["uncorrected"]["stature"]["value"], 1000.1);
  EXPECT_EQ(said["uncorrected"]["stature"]["interval"], json::array({987.7, 1012.4}));
  site.of_this_index = false;
  const json other = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(other), testing::IsEmpty());
  EXPECT_EQ(other["calibration_site"]["index_known"], false);
  report.site = nullptr;
  EXPECT_FALSE(json::parse(result_json(report)).contains("calibration_site"));
}

TEST(ResultJson, KeysComeInTheOrderOfTheDesign) {
  const auto v = nlohmann::ordered_json::parse(result_json(measured_report()));
  std::vector<std::string> keys;
  for (const auto& [key, unused] : v.items()) keys.push_back(key);
  EXPECT_THAT(keys, testing::ElementsAre("schema", "state", "guidance", "guidance_details", "frames", "source",
                                         "views", "estimator", "clothing", "measurements", "sex", "age", "size",
                                         "joints", "body", "paper"));
}

TEST(ResultJson, ArmsCloseNamesTheArms) {
  constexpr std::size_t kArmsBit = 5;
  PersonMeasurement report;
  report.source = measured_report().source;
  report.result.frames_seen = 40;
  report.result.guidance = static_cast<GuidanceSet>(Guidance::arms_close);
  report.result.guidance_frames[kArmsBit] = 30;
  report.result.arms_close = kRightArm;
  report.result.arms_close_frames = {29, 30};
  json v = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
  EXPECT_EQ(v["guidance_details"], json({{"arms_close", {"right"}}})) << "of the latest frame";
  report.result.guidance = static_cast<GuidanceSet>(Guidance::no_person);
  report.result.arms_close = 0;
  v = json::parse(result_json(report));
  EXPECT_EQ(v["guidance_details"], json({{"arms_close", {"left", "right"}}})) << "of most frames with that code";
  report.result.guidance_frames[kArmsBit] = 10;
  v = json::parse(result_json(report));
  EXPECT_EQ(v["guidance_details"], json::object()) << "few frames had the code";
}

TEST(ResultJson, WhoIsLeftOutIsNamedWithTheReason) {
  PersonMeasurement report;
  report.source = measured_report().source;
  EngineResult& r = report.result;
  r.frames_seen = 40;
  r.guidance = static_cast<GuidanceSet>(Guidance::depth_missing);
  r.user_count = 4;
  for (int i = 0; i < r.user_count; ++i) {
    r.users[static_cast<std::size_t>(i)].id = i + 1;
    r.users[static_cast<std::size_t>(i)].confirmed = i != 3;  // the last may be furniture
  }
  r.users[1].left_out = LeftOut::still;
  r.users[2].left_out = LeftOut::outside;
  r.users[3].left_out = LeftOut::outside;
  const json v = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
  EXPECT_EQ(v["guidance"], json({"DEPTH_MISSING"}));
  EXPECT_EQ(v["guidance_details"]["left_out"],
            json::parse(R"([{"user": 2, "reason": "still"}, {"user": 3, "reason": "outside"}])"));
}

TEST(ResultJson, HeelsAreNoGroundUnderTheFeet) {
  PersonMeasurement report = measured_report();
  report.result.guidance = report.result.plausibility.beside = static_cast<GuidanceSet>(Guidance::feet_raised);
  report.result.plausibility.ground_mm = 38.66F;
  json v = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
  EXPECT_EQ(v["guidance_details"], json::parse(R"({"feet_raised": {"ground_mm": 39}})"));
  report.result.plausibility.ground_mm = 0;
  report.result.plausibility.heels_mm = 48;
  v = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
  EXPECT_EQ(v["guidance_details"], json::parse(R"({"feet_raised": {"heels_mm": 48}})"));
}

TEST(ResultJson, AnUnmeasuredResultMeetsTheSchemaAndGuides) {
  PersonMeasurement report;
  report.source = measured_report().source;
  report.result.state = SessionState::lost;
  report.result.frames_seen = 40;
  report.result.guidance = static_cast<GuidanceSet>(Guidance::no_person);
  report.result.guidance_frames[0] = 12;
  report.result.guidance_frames[3] = 20;
  report.result.guidance_frames[8] = 19;
  report.result.guidance_seen = Guidance::no_person | Guidance::feet_cut;
  const json v = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
  EXPECT_EQ(v["guidance"], json::array({"NO_PERSON", "FEET_CUT"})) << "latest frame, and half of all frames";
  EXPECT_EQ(v["measurements"], json::object());
  EXPECT_FALSE(v.contains("sex"));
  EXPECT_FALSE(v.contains("body"));
  EXPECT_EQ(v["joints"], json::object());
}

TEST(ResultJson, InferredJointsAreMarkedUntilMeasured) {
  PersonMeasurement report = measured_report();
  report.result.joints_inferred = joint_bit(joint_index(Joint::LA)) | joint_bit(joint_index(Joint::RF));
  report.result.joints = report.result.measured_joints;
  report.result.has_joints = true;
  const json measured = json::parse(result_json(report));
  for (const auto& [name, joint] : measured["joints"].items())
    EXPECT_FALSE(joint.contains("inferred")) << name << " is the mean of frames";
  report.result.measured = false;
  const json v = json::parse(result_json(report));
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
  for (const auto& [name, joint] : v["joints"].items())
    EXPECT_EQ(joint.value("inferred", false), name == "LA" || name == "RF") << name;
}

TEST(ResultJson, TimingStandsApart) {
  PersonMeasurement report = measured_report();
  const std::string plain = result_json(report);
  report.result.sequence_gaps = 2;
  json timed = json::parse(result_json(report, ResultTiming{123.45, 67.8}));
  EXPECT_THAT(test::SchemaCheck(schema()).run(timed), testing::IsEmpty());
  EXPECT_EQ(timed["timing"]["sequence_gaps"], 2);
  timed.erase("timing");
  EXPECT_EQ(timed, json::parse(plain));
}

TEST(ResultJson, OddNumbersAndOddTextStayJson) {
  PersonMeasurement report = measured_report();
  report.result.answer.measurements[1].value = std::numeric_limits<float>::quiet_NaN();
  report.result.answer.measurements[1].high = std::numeric_limits<float>::infinity();
  report.source.name = "bad \xff utf-8";
  const json v = json::parse(result_json(report));
  EXPECT_EQ(v["measurements"]["sleeve_length"]["value"], nullptr);
  EXPECT_THAT(test::SchemaCheck(schema()).run(v), testing::IsEmpty());
}

TEST(SchemaCheck, FindsWhatIsWrong) {
  const json good = json::parse(result_json(measured_report()));
  const json rules = schema();
  const auto spoilt = [&](const std::function<void(json&)>& spoil) {
    json v = good;
    spoil(v);
    return test::SchemaCheck(rules).run(v).size();
  };
  EXPECT_EQ(spoilt([](json&) {}), 0U);
  EXPECT_EQ(spoilt([](json& v) { v.erase("state"); }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["extra"] = 1; }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["guidance"] = {"HELLO"}; }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["guidance"] = {"MOVING", "MOVING"}; }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["frames"]["seen"] = -1; }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["frames"]["seen"] = 1.5; }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["measurements"]["stature"]["unit"] = "cm"; }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["measurements"]["stature"]["interval"] = {1}; }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["sex"]["female"] = 1.5; }), 1U);
  EXPECT_EQ(spoilt([](json& v) { v["source"]["intrinsics"]["fx"] = 0; }), 1U);
  EXPECT_EQ(test::SchemaCheck(json{{"oneOf", 1}}).run(good).size(), 1U);
}

TEST(ResultJson, SameBytesOnOneAndTwoThreadsAndTwice) {
  std::string texts[4];
  for (int run = 0; run < 4; ++run) {
    EngineSettings settings = test::small_settings();
    settings.single_thread = run % 2 == 1;
    test::FakeStages::Control control;
    auto engine = create_engine(settings, std::make_unique<test::FakeStages>(control));
    ASSERT_TRUE(engine);
    for (int i = 0; i < 40; ++i) {
      test::Shot shot;
      shot.found = i > 3;
      shot.guidance = i % 4 == 0 ? 2 : 0;
      shot.refused = i % 5 == 0;
      shot.value = static_cast<std::uint16_t>(1000 + 7 * i);
      hal::FrameInfo info;
      info.sequence = static_cast<std::uint64_t>(i);
      ASSERT_TRUE((*engine)->push(test::FramePixels(shot).view(), info));
    }
    (*engine)->finish();
    PersonMeasurement report = measured_report();
    report.result = (*engine)->result();
    texts[run] = result_json(report);
    EXPECT_EQ(json::parse(texts[run])["state"], "MEASURED");
  }
  for (int run = 1; run < 4; ++run) EXPECT_EQ(texts[run], texts[0]);
}

}  // namespace
}  // namespace im2fit
