// SPDX-License-Identifier: Apache-2.0
// A day of a fitting room before the engine on its real stages: people who come, are measured, are cut off, are two,
// or stand in noise, and go, in an order that never repeats. The process must not grow. IM2FIT_ENGINE_FRAMES=1000000
// is the long run.
#include "tests/hal/long_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "core/rng.h"
#include "person/measuring_data.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"

namespace im2fit {
namespace {

constexpr int kWidth = 160, kHeight = 120;  // of the sensor, which hangs on its side
constexpr int kRotateDeg = 90;
constexpr int kClipFrames = 24;

using Frame = std::vector<std::uint16_t>;
using Clip = std::vector<Frame>;

enum class Act : int { person, pair, empty, noise };
constexpr std::size_t kPeople = 4;

class Day {
 public:
  explicit Day(const body::BodyModel& model) {
    for (std::uint64_t who = 0; who < kPeople; ++who) people_.push_back(clip(model, who, true, false));
    pair_ = clip(model, 1, true, true);
    empty_ = clip(model, 0, false, false);
  }
  // The next frame of an endless day.
  const Frame& next() {
    if (left_ == 0) begin();
    --left_;
    const Clip& clip = act_ == Act::pair ? pair_ : act_ == Act::empty ? empty_ : people_[who_];
    const Frame& frame = clip[static_cast<std::size_t>(rng_.index(kClipFrames))];
    if (act_ != Act::noise) return frame;
    noisy_ = frame;
    for (auto& z : noisy_)
      if (rng_.index(2) == 0) z = 0;
    return noisy_;
  }
  int visits() const { return visits_; }

 private:
  void begin() {
    act_ = act_ != Act::empty ? Act::empty : static_cast<Act>(std::array{0, 0, 0, 0, 0, 0, 1, 3}[pick(8)]);
    who_ = pick(kPeople);
    left_ = act_ == Act::empty ? 20 + rng_.index(40) : 30 + rng_.index(120);
    visits_ += act_ == Act::person ? 1 : 0;
  }
  std::size_t pick(int count) { return static_cast<std::size_t>(rng_.index(count)); }
  static Clip clip(const body::BodyModel& model, std::uint64_t who, bool person, bool pair) {
    lab::SceneOptions options;
    options.rotate_deg = kRotateDeg;
    options.person = person;
    options.distance_mm = 2600;
    options.yaw_deg = 0;
    if (pair) {
      lab::Bystander other;
      other.subject_seed = 5;
      other.path.from_x_mm = other.path.to_x_mm = 550;
      other.path.from_z_mm = other.path.to_z_mm = -500;
      options.others.push_back(other);
    }
    const Intrinsics sensor = lab::kinect_intrinsics(kWidth, kHeight);
    const lab::Subject subject = lab::draw_subject(model, lab::Family::training, 5, who);
    lab::VirtualScene scene(model, subject, options, {}, sensor, 5 + who);
    Clip out;
    Frame seen(static_cast<std::size_t>(kWidth) * kHeight);
    for (std::uint64_t i = 0; i < kClipFrames; ++i) {
      scene.render(i, {seen.data(), kWidth, kHeight});
      out.emplace_back(seen.size());
      hal::rotate_upright({seen.data(), kWidth, kHeight}, kRotateDeg, {out.back().data(), kHeight, kWidth});
    }
    return out;
  }

  std::vector<Clip> people_;
  Clip pair_, empty_;
  Rng rng_{2026};
  Act act_ = Act::noise;
  std::size_t who_ = 0;
  int left_ = 0, visits_ = 0;
  Frame noisy_;
};

TEST(LongRun, ADayOfPeopleLeavesTheProcessAsItWas) {
  MeasuringFiles files;
  for (const auto& [variable, path] :
       {std::pair{"IM2FIT_TRACKER", &files.tracker}, std::pair{"IM2FIT_INDEX", &files.index},
        std::pair{"IM2FIT_BODY", &files.body}}) {
    const char* given = std::getenv(variable);
    if (given == nullptr) GTEST_SKIP() << variable << " names no file";
    *path = given;
  }
  const auto data = load_measuring_data(files);
  ASSERT_TRUE(data) << data.error().message;
  Day day(*data->body_model);
  EngineSettings settings;
  settings.intrinsics = hal::rotate_upright(lab::kinect_intrinsics(kWidth, kHeight), kRotateDeg);
  settings.width = settings.intrinsics.width;
  settings.height = settings.intrinsics.height;
  settings.frames_wanted = 12;
  settings.one_after_another = true;
  auto engine = make_engine(settings, *data, "");
  ASSERT_TRUE(engine) << engine.error().message;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr int kUsualFrames = 400;
#else
  constexpr int kUsualFrames = 1500;
#endif
  const int frames = hal::frames_to_test("IM2FIT_ENGINE_FRAMES", kUsualFrames);
  hal::Growth growth(frames);
  int measured = 0;
  bool was_measured = false;
  for (int i = 0; i < frames; ++i) {
    growth.saw(i);
    hal::FrameInfo info;
    info.sequence = static_cast<std::uint64_t>(i);
    info.host_ns = (i + 1) * std::int64_t{33'333'333};
    ASSERT_TRUE((*engine)->push({day.next().data(), settings.width, settings.height}, info)) << i;
    const EngineResult result = (*engine)->result();
    if (result.measured && !was_measured) {
      ++measured;
      for (const auto& m : result.answer.measurements) ASSERT_TRUE(std::isfinite(m.value) && m.low < m.high) << i;
    }
    was_measured = result.measured;
  }
  ASSERT_TRUE((*engine)->wait_idle(-1));
  EXPECT_TRUE((*engine)->fault());
  EXPECT_EQ((*engine)->result().frames_dropped, 0U);
  std::printf("%d frames: %d people came, %d were measured\n", frames, day.visits(), measured);
  EXPECT_GE(2 * measured, day.visits());
  growth.expect_none();
}

}  // namespace
}  // namespace im2fit
