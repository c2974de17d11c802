// SPDX-License-Identifier: Apache-2.0
// Who or what cannot be measured, by the program: a rendered man in the ordinary room, and the same picture made
// wrong. The decisions on either side of their thresholds: tests/engine/plausibility_test.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>

#include "depth_folder.h"
#include "hal/source.h"
#include "measure_run.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"

namespace im2fit {
namespace {

using test::Picture;

constexpr int kWidth = 320, kHeight = 240;  // of the sensor, which hangs on its side
constexpr int kFrames = 12;
constexpr std::uint64_t kSeed = 8;
constexpr std::uint64_t kFramesSeed = 3;

// A pixel of the upright picture: its ray and its point.
struct Pixel {
  float ray_x = 0, ray_y = 0;
  Vec3f point;
  float height_mm = 0;
};
using Change = std::function<float(const Pixel&)>;  // the depth instead

class Limits : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::have_data()) GTEST_SKIP() << "no body, tracker or index file";
    auto model = body::BodyModel::load(test::body_path());
    ASSERT_TRUE(model) << model.error().message;
    model_.emplace(std::move(*model));
    subject_ = lab::draw_subject(*model_, lab::Family::held_out, kSeed, 0);
  }

  float truth(Measurement m) const { return subject_.truth[measurement_index(m)]; }

  // The frames of the man in this pose, each pixel changed.
  void show(const Change& change = nullptr, lab::StandingPose pose = lab::StandingPose::relaxed) {
    lab::SceneOptions options;
    options.pose = pose;
    options.yaw_deg = 0;
    const Intrinsics sensor = lab::kinect_intrinsics(kWidth, kHeight);
    lab::VirtualScene scene(*model_, subject_, options, {}, sensor, kFramesSeed);
    const Intrinsics k = hal::rotate_upright(sensor, 90);
    floor_ = scene.floor();
    const JointSet joints = scene.joints(0);
    head_ = joints[Joint::HE];
    feet_ = (joints[Joint::LF] + joints[Joint::RF]) * 0.5F;
    std::vector<Picture> pictures;
    Picture delivered(kWidth, kHeight, 0);
    for (int i = 0; i < kFrames; ++i) {
      const DepthImage in(delivered.mm.data(), kWidth, kHeight);
      scene.render(static_cast<std::uint64_t>(i), in);
      Picture upright(kHeight, kWidth, 0);
      hal::rotate_upright(in, 90, {upright.mm.data(), kHeight, kWidth});
      if (change) alter(upright, k, change);
      pictures.push_back(std::move(upright));
    }
    test::CameraText camera;
    camera.width = k.width;
    camera.height = k.height;
    camera.centre_x = static_cast<double>(k.cx);
    camera.centre_y = static_cast<double>(k.cy);
    test::write_depth_folder(folder_.path("clip"), pictures, camera);
  }

  void alter(Picture& picture, const Intrinsics& k, const Change& change) const {
    for (int v = 0; v < picture.height; ++v)
      for (int u = 0; u < picture.width; ++u) {
        std::uint16_t& mm = picture.at(u, v);
        if (mm == 0) continue;
        Pixel pixel;
        pixel.ray_x = (static_cast<float>(u) - k.cx) / k.fx;
        pixel.ray_y = (static_cast<float>(v) - k.cy) / k.fy;
        pixel.point = unproject(k, static_cast<float>(u), static_cast<float>(v), static_cast<float>(mm));
        pixel.height_mm = dot(floor_.up, pixel.point) + floor_.camera_height_mm;
        mm = static_cast<std::uint16_t>(std::lround(std::clamp(change(pixel), 0.0F, 65535.0F)));
      }
  }

  // Along the floor.
  float level_from(Vec3f centre, Vec3f p) const {
    const Vec3f away = p - centre;
    return norm(away - floor_.up * dot(floor_.up, away));
  }

  nlohmann::json measured(int exit_code) {
    const std::string out = folder_.path("out");
    const test::Run run = test::measure(folder_.path("clip"), out, {"--only", "result"});
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    test::expect_honest(run, out);
    return nlohmann::json::parse(test::read_text(out + "/result.json"), nullptr, false);
  }
  // No answer, only this code; its numbers.
  nlohmann::json refused(const std::string& code, const std::string& detail) {
    const nlohmann::json result = measured(3);
    EXPECT_EQ(result["guidance"], nlohmann::json::array({code}));
    EXPECT_EQ(result["measurements"], nlohmann::json::object());
    return result["guidance_details"][detail];
  }
  // An answer with these codes beside it; its stature.
  nlohmann::json answered(const nlohmann::json& codes) {
    result_ = measured(0);
    EXPECT_EQ(result_["guidance"], codes);
    return result_["measurements"]["stature"];
  }
  void expect_inside(const nlohmann::json& stature) const {
    EXPECT_LE(stature["interval"][0].get<float>(), truth(Measurement::stature));
    EXPECT_GE(stature["interval"][1].get<float>(), truth(Measurement::stature));
  }

  test::TestFolder folder_;
  std::optional<body::BodyModel> model_;
  lab::Subject subject_;
  FloorPlane floor_;
  Vec3f head_, feet_;
  nlohmann::json result_;
};

TEST_F(Limits, AnOrdinaryManIsMeasuredAndNothingIsSaid) {
  show();
  expect_inside(answered(nlohmann::json::array()));
  EXPECT_EQ(result_["guidance_details"], nlohmann::json::object());
}

TEST_F(Limits, DistancesInPlaceOfDepthsBendTheFloor) {
  show([](const Pixel& p) { return p.point.z * std::sqrt(1 + p.ray_x * p.ray_x + p.ray_y * p.ray_y); });
  EXPECT_NEAR(refused("FLOOR_BENT", "floor_bent")["bend"].get<double>(), 0.44, 0.03);
}

TEST_F(Limits, BentKneesAreNotUpright) {
  show(nullptr, lab::StandingPose::squat);
  EXPECT_GT(refused("NOT_UPRIGHT", "not_upright")["knees_deg"].get<double>(), 24);
}

TEST_F(Limits, AChildIsOutOfThePopulation) {
  show([](const Pixel& p) { return 0.72F * p.point.z; });
  const auto numbers = refused("OUT_OF_POPULATION", "out_of_population");
  EXPECT_NEAR(numbers["stature_mm"].get<float>(), 0.72F * truth(Measurement::stature), 15);
  EXPECT_EQ(numbers["from_mm"], 1400);
  EXPECT_EQ(numbers["to_mm"], 2100);
}

TEST_F(Limits, AGiantIsOutOfThePopulation) {
  const float scale = 2200 / truth(Measurement::stature);
  show([&](const Pixel& p) { return scale * p.point.z; });
  EXPECT_NEAR(refused("OUT_OF_POPULATION", "out_of_population")["stature_mm"].get<float>(), 2200, 30);
}

// The floor lies lower than the round plate that the man stands on.
TEST_F(Limits, AScaleUnderTheFeetIsMeasuredFromAndTold) {
  for (const float plate_mm : {30.0F, 55.0F}) {
    show([&](const Pixel& p) {
      const bool floor = std::fabs(p.height_mm) < 30 && level_from(feet_, p.point) > 220;
      const float slope = floor_.up.x * p.ray_x + floor_.up.y * p.ray_y + floor_.up.z;
      if (!floor || slope > -0.01F) return p.point.z;
      return p.point.z - plate_mm / slope;
    });
    expect_inside(answered({"FEET_RAISED"}));
    EXPECT_NEAR(result_["guidance_details"]["feet_raised"]["ground_mm"].get<float>(), plate_mm, 5);
  }
}

TEST_F(Limits, ACrownWithoutDepthIsToldAndTheIntervalReachesIt) {
  for (const float lost_mm : {100.0F, 120.0F}) {
    show([&](const Pixel& p) {
      const bool hair = p.height_mm > truth(Measurement::stature) - lost_mm && level_from(head_, p.point) < 200;
      return hair ? 0 : p.point.z;
    });
    expect_inside(answered({"HEAD_UNSEEN"}));
    EXPECT_GT(result_["guidance_details"]["head_unseen"]["added_mm"].get<float>(), 0);
  }
}

// Fifths and quarters make a room, too; in one of them the man is of usual height.
TEST_F(Limits, ValuesOfAnotherUnitAreNamedByTheUnitThatWorks) {
  for (const auto& [factor, unit] : {std::pair(5.0F, "0.2"), {4.0F, "0.25"}, {2.0F, "0.5"}}) {
    show([factor = factor](const Pixel& p) { return factor * p.point.z; });
    const std::string out = folder_.path("out");
    const test::Run run = test::measure(folder_.path("clip"), out, {"--only", "result"});
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_THAT(run.err, testing::HasSubstr(std::string("try --unit ") + unit + "\n"));
    const auto result = nlohmann::json::parse(test::read_text(out + "/result.json"), nullptr, false);
    EXPECT_EQ(result["diagnosis"]["code"], "UNIT");
    EXPECT_THAT(run.err, testing::HasSubstr(result["diagnosis"]["text"].get<std::string>()));
    const test::Run right = test::measure(folder_.path("clip"), out, {"--only", "result", "--unit", unit});
    EXPECT_EQ(right.exit_code, 0) << right.err;
    // Of a unit already given, and wrong: the one in its place.
    const std::string given = fmt::format("{}", 10 / factor);
    const test::Run wrong = test::measure(folder_.path("clip"), out, {"--only", "result", "--unit", given});
    EXPECT_EQ(wrong.exit_code, 3);
    EXPECT_THAT(wrong.err, testing::HasSubstr(std::string("try --unit ") + unit + "\n"));
  }
}

// Pictures that people found in the field (IM2FIT_SHARED).
TEST_F(Limits, TheCasesFoundAreRefusedOrRight) {
  const char* given = std::getenv("IM2FIT_SHARED");
  const std::string cases = std::string(given != nullptr ? given : IM2FIT_SHARED_DEFAULT) + "/cases/";
  struct Case {
    const char *folder, *code;
    int exit_code;
    float stature_mm;
  };
  for (const Case& one : {Case{"child-of-1271mm", "OUT_OF_POPULATION", 3, 0},
                          {"squat-is-measured", "NOT_UPRIGHT", 3, 0},
                          {"radial-distance", "FLOOR_BENT", 3, 0},
                          {"on-a-scale-40mm", "FEET_RAISED", 0, 1816},
                          {"hair-without-depth", "HEAD_UNSEEN", 0, 1816}}) {
    if (!std::filesystem::exists(cases + one.folder))
      GTEST_SKIP() << "no " << cases << one.folder << ": set IM2FIT_SHARED to the shared folder";
    const std::string clip = folder_.path(one.folder);
    std::filesystem::create_directories(clip);
    std::filesystem::copy_file(cases + one.folder + "/camera.yaml", clip + "/camera.yaml");
    for (int i = 0; i < 30; ++i)
      std::filesystem::copy_file(cases + one.folder + "/000000.png", clip + "/" + test::frame_name(i, "png"));
    const std::string out = folder_.path(std::string("out-") + one.folder);
    const test::Run run = test::measure(clip, out, {"--only", "result"});
    EXPECT_EQ(run.exit_code, one.exit_code) << one.folder << run.err;
    const auto result = nlohmann::json::parse(test::read_text(out + "/result.json"), nullptr, false);
    EXPECT_EQ(result["guidance"], nlohmann::json::array({one.code})) << one.folder;
    if (one.exit_code != 0) continue;
    const auto& interval = result["measurements"]["stature"]["interval"];
    EXPECT_LE(interval[0].get<float>(), one.stature_mm) << one.folder;
    EXPECT_GE(interval[1].get<float>(), one.stature_mm) << one.folder;
  }
}

}  // namespace
}  // namespace im2fit
