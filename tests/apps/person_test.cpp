// SPDX-License-Identifier: Apache-2.0
// One rendered person is measured; two people, or one cut at an edge, get guidance instead of numbers.
#include <algorithm>
#include <optional>

#include "measure_run.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"

namespace im2fit {
namespace {

using test::Picture;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr int kFrames = 14;

// A person 3 m before a level camera, and the room without the person: wall and floor have one depth per row.
struct Scene {
  std::vector<Picture> depth;
  std::vector<Picture> mask;
  lab::PixelBox box;
};

Scene render(const body::BodyModel& model, std::uint64_t person) {
  lab::SceneOptions options;
  options.rotate_deg = 0;
  options.distance_mm = 3000;
  options.camera_height_mm = 950;
  options.pitch_deg = 0;
  options.yaw_deg = 0;
  options.wall_distance_mm = 1200;
  const lab::Subject subject = lab::draw_subject(model, lab::Family::training, 5, person);
  lab::VirtualScene scene(model, subject, options, lab::exact_sensor(), lab::kinect_intrinsics(kWidth, kHeight), 5);
  Scene out;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(kWidth) * kHeight);
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    Picture depth(kWidth, kHeight, 0);
    scene.render(i, {depth.mm.data(), kWidth, kHeight});
    scene.person_mask({mask.data(), kWidth, kHeight});
    Picture where(kWidth, kHeight, 0);
    std::copy(mask.begin(), mask.end(), where.mm.begin());
    out.depth.push_back(depth);
    out.mask.push_back(where);
    out.box = i == 0 ? scene.person_box() : lab::bounding(out.box, scene.person_box());
  }
  return out;
}

// The empty room of frame `i`, as seen just beside the person, with the person's pixels moved by `shift` on top.
void put(const Scene& scene, std::size_t i, int shift, Picture& out) {
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int to = u + shift;
      if (scene.mask[i].at(u, v) == 0 || to < 0 || to >= kWidth) continue;
      out.at(to, v) = out.at(to, v) == 0 ? scene.depth[i].at(u, v) : std::min(out.at(to, v), scene.depth[i].at(u, v));
    }
  }
}

Picture empty_room(const Scene& scene, std::size_t i) {
  Picture room(kWidth, kHeight, 0);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) room.at(u, v) = scene.depth[i].at(scene.box.u0 - 4, v);
  return room;
}

struct Window {
  int u0 = 0, v0 = 0, u1 = kWidth, v1 = kHeight;
};

// A smaller picture of the same camera: its edges cut what reaches beyond.
Picture cut(const Picture& picture, const Window& window) {
  Picture out(window.u1 - window.u0, window.v1 - window.v0, 0);
  for (int v = 0; v < out.height; ++v)
    for (int u = 0; u < out.width; ++u) out.at(u, v) = picture.at(u + window.u0, v + window.v0);
  return out;
}

class Person : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!test::have_data()) return;
    auto model = body::BodyModel::load(test::body_path());
    ASSERT_TRUE(model) << model.error().message;
    one_.emplace(render(*model, 2));
    other_.emplace(render(*model, 3));
  }
  static void TearDownTestSuite() {
    one_.reset();
    other_.reset();
  }
  void SetUp() override {
    IM2FIT_NEED_DATA();
    ASSERT_TRUE(one_ && other_);
    ASSERT_GT(one_->box.u0, 8);
    ASSERT_LT(one_->box.v1, kHeight - 4) << "the feet must be in view before they are cut";
    ASSERT_GT(one_->box.v0, 4);
  }

  // The person moved aside by `shift`, seen through `window`.
  test::Run measure_through(const Window& window, const std::vector<std::string>& more = {},
                            const test::RunOptions& options = {}, int shift = 0) {
    std::vector<Picture> pictures;
    for (std::size_t i = 0; i < kFrames; ++i) {
      Picture picture = empty_room(*one_, i);
      put(*one_, i, shift, picture);
      pictures.push_back(cut(picture, window));
    }
    test::CameraText camera;
    camera.width = window.u1 - window.u0;
    camera.height = window.v1 - window.v0;
    camera.centre_x -= window.u0;
    camera.centre_y -= window.v0;
    test::write_depth_folder(folder_.path("depth"), pictures, camera);
    return test::measure(folder_.path("depth"), out(), more, options);
  }
  void expect_guidance(const test::Run& run, const char* code) const {
    EXPECT_EQ(run.exit_code, 3) << run.err;
    test::expect_honest(run, out());
    EXPECT_THAT(test::guidance_in(out()), testing::Contains(code));
    EXPECT_THAT(run.err, testing::HasSubstr(code));
  }
  std::string out() const { return folder_.path("out"); }

  const test::TestFolder folder_;
  static inline std::optional<Scene> one_;
  static inline std::optional<Scene> other_;
};

TEST_F(Person, WholeAndAloneIsMeasured) {
  const test::Run run = measure_through({});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  test::expect_honest(run, out());
  const auto result = nlohmann::json::parse(test::read_text(out() + "/result.json"));
  EXPECT_EQ(result["state"], "MEASURED");
  EXPECT_TRUE(result["guidance"].empty()) << result["guidance"];
  EXPECT_THAT(test::files_in(out()), testing::IsSupersetOf({"result.json", "avatar.glb", "avatar.obj", "avatar.mtl",
                                                            "avatar_skin.png", "avatar.bvh", "overlay.png"}));
  // Only the owner may read a person's measurements.
  for (const auto& file : std::filesystem::directory_iterator(out()))
    EXPECT_EQ(file.status().permissions(), std::filesystem::perms(0600)) << file.path();
}

TEST_F(Person, TheTableShowsThePapersValuesWhenAsked) {
  const test::Run plain = measure_through({});
  EXPECT_THAT(plain.out, testing::HasSubstr("chest_girth mm"));
  EXPECT_THAT(plain.out, testing::Not(testing::HasSubstr("paper")));
  const test::Run both = measure_through({}, {"--paper"});
  EXPECT_THAT(both.out, testing::HasSubstr("paper's"));
}

// Ten times a Kinect's noise: the answer, if any, must not be a measurement of a standing body.
TEST_F(Person, InTenfoldNoiseIsNotMeasured) {
  std::uint32_t state = 1;
  const auto uniform = [&] {  // -1 to 1
    state = state * 1664525U + 1013904223U;
    return static_cast<double>(state >> 8) / (1 << 23) - 1;
  };
  std::vector<Picture> pictures;
  for (std::size_t i = 0; i < kFrames; ++i) {
    Picture picture = empty_room(*one_, i);
    put(*one_, i, 0, picture);
    for (std::uint16_t& z : picture.mm) {
      if (z == 0) continue;
      // Khoshelham and Elberink 2012: 1.425e-6 z^2; the sum of three such has that spread.
      const double sd = 14.25e-6 * z * z;
      const double noisy = z + sd * (uniform() + uniform() + uniform());
      z = static_cast<std::uint16_t>(std::clamp(noisy, 0.0, 65535.0));
    }
    pictures.push_back(picture);
  }
  test::write_depth_folder(folder_.path("depth"), pictures);
  const test::Run run = test::measure(folder_.path("depth"), out());
  EXPECT_EQ(run.exit_code, 3) << run.err;
  test::expect_honest(run, out());
}

// A clock that is set while a person stands there: forward by a year, and a recording that was stopped for an hour.
TEST_F(Person, IsMeasuredThoughTheClockJumps) {
  std::vector<Picture> pictures;
  std::string times = "frame,host_ns\n";
  for (std::size_t i = 0; i < kFrames; ++i) {
    Picture picture = empty_room(*one_, i);
    put(*one_, i, 0, picture);
    pictures.push_back(picture);
    const std::int64_t jumped_s = i < 4 ? 0 : i < 5 ? 31'536'000 : 31'539'600;
    times += std::to_string(i) + "," + std::to_string(jumped_s * 1'000'000'000 + static_cast<int>(i) * 33'000'000LL) +
             "\n";
  }
  test::write_depth_folder(folder_.path("depth"), pictures);
  test::write_text(folder_.path("depth") + "/timestamps.csv", times);
  const test::Run run = test::measure(folder_.path("depth"), out(), {"--frames", "5"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  test::expect_honest(run, out());
}

TEST_F(Person, JsonIsAllThatIsOnStdout) {
  const test::Run run = measure_through({}, {"--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, test::read_text(out() + "/result.json"));
  EXPECT_TRUE(nlohmann::json::accept(run.out));
}

// From the ankles to the hips.
TEST_F(Person, CutAtTheFeetGetsGuidance) {
  const int height = one_->box.v1 - one_->box.v0;
  for (const int twentieths : {1, 3, 10}) {
    SCOPED_TRACE(twentieths);
    expect_guidance(measure_through({.v1 = one_->box.v1 - height * twentieths / 20}), "FEET_CUT");
  }
}

// From the forehead to the chest.
TEST_F(Person, CutAtTheHeadGetsGuidance) {
  const int height = one_->box.v1 - one_->box.v0;
  for (const int twentieths : {2, 4, 6}) {
    SCOPED_TRACE(twentieths);
    expect_guidance(measure_through({.v0 = one_->box.v0 + height * twentieths / 20}), "HEAD_CUT");
  }
}

// Legs and hips may be furniture: the message says what the picture must show.
TEST_F(Person, LegsAloneAreNoPersonAndToldWhatIsMissing) {
  const test::Run run = measure_through({.v0 = 110});  // the crotch; the picture's centre must lie in it
  expect_guidance(run, "NO_PERSON");
  EXPECT_THAT(run.err, testing::HasSubstr("the picture must reach from the floor to above the head"));
}

// Cut off at the hips, with the joints written: a message says that the motion of unseen legs is inferred.
TEST_F(Person, AHalfPersonsMotionSaysWhatIsMadeUp) {
  const Window upper_half = {.v1 = one_->box.v1 - (one_->box.v1 - one_->box.v0) * 9 / 20};
  for (const char* name : {"half.bvh", "half.glb", "half.csv"}) {
    const std::string path = folder_.path(name);
    const test::Run run = measure_through(upper_half, {"--motion", path});
    EXPECT_EQ(run.exit_code, 3) << run.err;
    EXPECT_TRUE(std::filesystem::exists(path));
    EXPECT_FALSE(std::filesystem::exists(out() + "/avatar.bvh")) << "there is no measured body";
    const bool said = run.err.find("LK, RK, LF, RF were not seen in most frames") != std::string::npos;
    EXPECT_EQ(said, std::string(name) != "half.csv") << run.err;
  }
}

TEST_F(Person, CutAtTheSideGetsGuidance) {
  const int quarter_out = -(one_->box.u0 + (one_->box.u1 - one_->box.u0) / 4);
  expect_guidance(measure_through({}, {}, {}, quarter_out), "SIDE_CUT");
}

TEST_F(Person, BesideAnotherGetsGuidance) {
  constexpr int kShift = 62;  // 1.3 m between them at 3 m
  ASSERT_LT(one_->box.u1 - kShift, other_->box.u0 + kShift) << "they must not touch";
  std::vector<Picture> pictures;
  for (std::size_t i = 0; i < kFrames; ++i) {
    Picture picture = empty_room(*one_, i);
    put(*one_, i, -kShift, picture);
    put(*other_, i, kShift, picture);
    pictures.push_back(picture);
  }
  test::write_depth_folder(folder_.path("depth"), pictures);
  expect_guidance(test::measure(folder_.path("depth"), out()), "SEVERAL_PEOPLE");
}

// Ten in one picture, more than are followed: the nearest person is the target, and not measured among so many.
TEST_F(Person, AmongTenGetsGuidance) {
  const auto model = body::BodyModel::load(test::body_path());
  ASSERT_TRUE(model) << model.error().message;
  lab::SceneOptions options;
  options.rotate_deg = 0;
  options.distance_mm = 2600;
  options.camera_height_mm = 1100;
  options.yaw_deg = 0;
  options.wall_distance_mm = 3500;
  for (int i = 0; i < 9; ++i) {
    lab::Bystander other;
    other.subject_seed = 11;
    other.subject_index = static_cast<std::uint64_t>(i);
    other.yaw_deg = static_cast<float>(40 * i);
    other.path.from_x_mm = other.path.to_x_mm = static_cast<float>(450 * (i - 4));
    other.path.from_z_mm = other.path.to_z_mm = static_cast<float>(-500 - 300 * (i % 4));
    options.others.push_back(other);
  }
  const lab::Subject subject = lab::draw_subject(*model, lab::Family::training, 5, 2);
  lab::VirtualScene scene(*model, subject, options, {}, lab::kinect_intrinsics(kWidth, kHeight), 5);
  std::vector<Picture> pictures;
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    pictures.emplace_back(kWidth, kHeight, 0);
    scene.render(i, {pictures.back().mm.data(), kWidth, kHeight});
  }
  test::write_depth_folder(folder_.path("depth"), pictures);
  expect_guidance(test::measure(folder_.path("depth"), out()), "SEVERAL_PEOPLE");
}

TEST_F(Person, OnAFullDiskLeavesWholeFilesOnly) {
  for (const rlim_t room : {rlim_t{0}, rlim_t{3'000}, rlim_t{200'000}}) {
    SCOPED_TRACE("room for " + std::to_string(room) + " bytes");
    std::filesystem::remove_all(folder_.path("depth"));
    test::RunOptions full;
    full.file_bytes_max = room;
    const test::Run run = measure_through({}, {}, full);
    EXPECT_EQ(run.exit_code, 1) << run.err;
    test::expect_honest(run, out());
    // The answer comes first: where there is room for its 50 kB (garments in every size) it is there.
    EXPECT_EQ(std::filesystem::exists(out() + "/result.json"), room > 100'000);
  }
}

}  // namespace
}  // namespace im2fit
