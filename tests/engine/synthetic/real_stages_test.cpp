// SPDX-License-Identifier: Apache-2.0
// The engine on its real stages: a rendered person, the trained tracker, and an index of random people made here.
// What the index answers means nothing; that the same frames give the same bytes and that nothing allocates does.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>

#include "allocations.h"
#include "body/params_vector.h"
#include "core/file.h"
#include "core/rng.h"
#include "engine/engine.h"
#include "hal/source.h"
#include "report/result_json.h"
#include "train/camera/virtual_camera.h"
#include "train/index/builder.h"
#include "train/population/population.h"

namespace im2fit {
namespace {

std::string data_file(const char* variable, const char* name) {
  if (const char* path = std::getenv(variable)) return path;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  return (cache != nullptr ? std::string(cache) : std::string(home != nullptr ? home : "") + "/.cache") + "/im2fit/" +
         name;
}

constexpr int kFrameCount = 24;
constexpr int kTurnFirst = 20;  // of the other clip: a turn of 45 frames, then the back
constexpr int kTurnFrames = 45;
constexpr int kTurnClipFrames = 110;
constexpr int kSensorWidth = 320;
constexpr int kSensorHeight = 240;
constexpr int kRotateDeg = 90;

Result<index::Index> random_index(std::size_t modifier_count, std::uint32_t tracker_key,
                                  std::size_t feature_size = kFeatureSize) {
  index::BuildOptions options;
  options.tracker_key = tracker_key;
  options.dimensions = 4;
  options.population_version = body::kPopulationVersion;
  std::vector<index::Sample> samples;
  Rng rng(9);
  for (std::uint64_t i = 0; i < 40; ++i) {
    index::Sample sample;
    sample.subject = i;
    sample.feature.resize(feature_size);
    for (float& f : sample.feature) f = static_cast<float>(rng.normal());
    for (float& t : sample.truth) t = static_cast<float>(rng.normal(1000, 50));
    sample.truth[measurement_index(Measurement::stature)] = static_cast<float>(rng.normal(1700, 60));
    sample.truth[measurement_index(Measurement::weight)] = static_cast<float>(rng.normal(70, 8));
    sample.woman = i % 2 == 1;
    sample.age_years = 18 + 1.4F * static_cast<float>(i);
    sample.body = body::pack_params({}, modifier_count);
    samples.push_back(sample);
  }
  auto bytes = index::build_index(options, index::source_of(samples));
  if (!bytes) return bytes.error();
  return index::Index::parse(std::move(*bytes), "random index");
}

class RealStages : public testing::Test {
 protected:
  // Rendering and the index take most of the time: once for all cases.
  static void SetUpTestSuite() {
    const std::string body_path = data_file("IM2FIT_BODY", "body.i2b");
    const std::string tracker_path = data_file("IM2FIT_TRACKER", "tracker.i2t");
    if (!std::ifstream(body_path) || !std::ifstream(tracker_path)) return;
    auto model = body::BodyModel::load(body_path);
    ASSERT_TRUE(model) << model.error().message;
    auto bytes = read_file(tracker_path);
    ASSERT_TRUE(bytes);
    data_ = new Data{std::move(*model), std::move(*bytes), {}, {}, {}, {}, {}};
    auto tracker = JointModel::parse(data_->tracker_bytes, tracker_path);
    ASSERT_TRUE(tracker) << tracker.error().message;
    data_->tracker.emplace(std::move(*tracker));
    auto index = random_index(data_->model.modifier_names().size(), data_->tracker->key());
    ASSERT_TRUE(index) << index.error().message;
    data_->index.emplace(std::move(*index));
    render();
  }
  static void TearDownTestSuite() {
    delete data_;
    data_ = nullptr;
  }
  void SetUp() override {
    if (data_ == nullptr || !data_->index) GTEST_SKIP() << "no body or tracker file: run im2fit-lab fetch and train";
  }

  static void render() {
    render({}, kFrameCount, data_->frames);
    render({kTurnFirst, kTurnFrames}, kTurnClipFrames, data_->turn_frames);
  }
  static void render(lab::AboutTurn turn, int frame_count, std::vector<std::vector<std::uint16_t>>& frames) {
    const Intrinsics sensor = lab::kinect_intrinsics(kSensorWidth, kSensorHeight);
    const lab::Subject subject = lab::draw_subject(data_->model, lab::Family::training, 5, 2);
    lab::SceneOptions options;
    options.rotate_deg = kRotateDeg;
    options.turn = turn;
    frames = rendered(subject, options, frame_count);
    data_->intrinsics = hal::rotate_upright(sensor, kRotateDeg);
  }
  static std::vector<std::vector<std::uint16_t>> rendered(const lab::Subject& subject,
                                                          const lab::SceneOptions& options, int frame_count) {
    lab::VirtualScene scene(data_->model, subject, options, {}, lab::kinect_intrinsics(kSensorWidth, kSensorHeight),
                            5);
    std::vector<std::uint16_t> landscape(static_cast<std::size_t>(kSensorWidth) * kSensorHeight);
    const DepthImage in(landscape.data(), kSensorWidth, kSensorHeight);
    std::vector<std::vector<std::uint16_t>> frames;
    for (int i = 0; i < frame_count; ++i) {
      scene.render(static_cast<std::uint64_t>(i), in);
      frames.emplace_back(landscape.size());
      hal::rotate_upright(in, kRotateDeg, {frames.back().data(), kSensorHeight, kSensorWidth});
    }
    return frames;
  }

  static std::unique_ptr<Engine> make_engine(bool single_thread, Turn turn = Turn::none, FrameWatch watch = nullptr,
                                             SensorKind sensor = SensorKind::unknown) {
    EngineSettings settings;
    settings.width = data_->intrinsics.width;
    settings.height = data_->intrinsics.height;
    settings.intrinsics = data_->intrinsics;
    settings.frames_wanted = 12;
    settings.single_thread = single_thread;
    settings.turn = turn;
    settings.watch = std::move(watch);
    settings.sensor = sensor;
    auto engine = Engine::create(settings, *data_->tracker, *data_->index);
    EXPECT_TRUE(engine) << engine.error().message;
    return std::move(*engine);
  }

  static Status push(Engine& engine, std::uint64_t i, const std::vector<std::uint16_t>& frame) {
    hal::FrameInfo info;
    info.sequence = i;
    info.host_ns = static_cast<std::int64_t>(i + 1) * 33333333;
    return engine.push({frame.data(), data_->intrinsics.width, data_->intrinsics.height}, info);
  }
  static Status push(Engine& engine, std::uint64_t i) { return push(engine, i, data_->frames[i % kFrameCount]); }

  struct Data {
    body::BodyModel model;
    std::vector<std::byte> tracker_bytes;
    std::optional<JointModel> tracker;
    std::optional<index::Index> index;
    std::vector<std::vector<std::uint16_t>> frames;
    std::vector<std::vector<std::uint16_t>> turn_frames;
    Intrinsics intrinsics;
  };
  static inline Data* data_ = nullptr;
};

TEST_F(RealStages, ClothesNeedAnIndexThatKnowsThem) {
  EngineSettings settings;
  settings.clothing = ClothingGiven::dressed;
  const auto engine = Engine::create(settings, *data_->tracker, *data_->index);
  ASSERT_FALSE(engine);
  EXPECT_EQ(engine.error().code, ErrorCode::unsupported);
  EXPECT_NE(engine.error().message.find("no people in clothes"), std::string::npos) << engine.error().message;
}

TEST_F(RealStages, AnIndexOfAnotherTrackerIsRefused) {
  const std::size_t modifiers = data_->model.modifier_names().size();
  EngineSettings settings;
  settings.width = data_->intrinsics.width;
  settings.height = data_->intrinsics.height;
  settings.intrinsics = data_->intrinsics;
  EXPECT_TRUE(Engine::create(settings, *data_->tracker, *data_->index));
  const auto other = random_index(modifiers, data_->tracker->key() ^ 1U, 10);  // of so few values it is quickly made
  ASSERT_TRUE(other) << other.error().message;
  const auto engine = Engine::create(settings, *data_->tracker, *other);
  ASSERT_FALSE(engine);
  EXPECT_EQ(engine.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(engine.error().message.find("another tracker"), std::string::npos) << engine.error().message;
}

TEST_F(RealStages, AKinectIsKnownGivenOrNotAndTimeOfFlightIsTakenAsGiven) {
  std::vector<MeasurementValues> reported;
  for (const SensorKind kind : {SensorKind::unknown, SensorKind::structured_light, SensorKind::time_of_flight}) {
    auto engine = make_engine(true, Turn::none, nullptr, kind);
    for (std::uint64_t i = 0; i < kFrameCount; ++i) ASSERT_TRUE(push(*engine, i));
    engine->finish();
    const EngineResult result = engine->result();
    ASSERT_TRUE(result.measured);
    MeasurementValues& values = reported.emplace_back();
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      values[m] = static_cast<float>(result.answer.measurements[m].value);
  }
  EXPECT_EQ(reported[0], reported[1]);
  EXPECT_NE(reported[1], reported[2]);
}

TEST_F(RealStages, MeasureWithTheSameBytesOnOneAndTwoThreadsAndTwice) {
  std::string texts[3];
  for (int run = 0; run < 3; ++run) {
    auto engine = make_engine(run == 1);
    for (std::uint64_t i = 0; i < kFrameCount; ++i) ASSERT_TRUE(push(*engine, i));
    engine->finish();
    hal::SourceInfo source;
    source.intrinsics = data_->intrinsics;
    const auto person =
        measurement_of(*engine, {&*data_->index, &data_->model, &builtin_size_system(), nullptr}, source);
    ASSERT_TRUE(person) << person.error().message;
    ASSERT_TRUE(person->result.measured) << "guidance bits " << person->result.guidance_seen;
    EXPECT_EQ(engine->fused_mask().width, data_->intrinsics.width);
    const AgeAnswer& age = person->result.age;
    EXPECT_GE(age.years.low, 18);
    EXPECT_LT(age.years.low, age.years.value);
    EXPECT_LT(age.years.value, age.years.high);
    EXPECT_LE(age.years.high, 75);
    ASSERT_TRUE(person->size && person->body);
    texts[run] = result_json(*person);
  }
  EXPECT_EQ(texts[1], texts[0]);
  EXPECT_EQ(texts[2], texts[0]);
}

TEST_F(RealStages, NothingAllocatesOver300Frames) {
  auto engine = make_engine(false);
  test::arm_allocation_count();
  bool pushed = true;
  for (int person = 0; person < 3; ++person) {
    for (std::uint64_t i = 0; i < 100; ++i) pushed = static_cast<bool>(push(*engine, i)) && pushed;
    engine->finish();
    if (person < 2) engine->reset();
  }
  const long allocations = test::disarm_allocation_count();
  EXPECT_EQ(allocations, 0);
  EXPECT_TRUE(pushed);
  EXPECT_TRUE(engine->result().measured);
}

// What a session reported, frame by frame.
struct Story {
  std::vector<SessionState> states;  // without repeats
  std::vector<EngineResult> frames;
  FrameWatch watch() {
    return [this](const FrameSeen& frame) {
      frames.push_back(frame.result);
      if (states.empty() || states.back() != frame.result.state) states.push_back(frame.result.state);
    };
  }
};

std::string values_of(const EngineResult& r) {
  PersonMeasurement person;
  person.result = r;
  person.result.measured = true;
  const std::string text = result_json(person);
  return text.substr(text.find("\"measurements\""));
}

TEST_F(RealStages, APersonWhoTurnsRoundIsMeasuredFromBothSides) {
  std::string texts[2];
  for (const bool single_thread : {true, false}) {
    Story story;
    auto engine = make_engine(single_thread, Turn::back, story.watch());
    for (std::uint64_t i = 0; i < kTurnClipFrames; ++i) ASSERT_TRUE(push(*engine, i, data_->turn_frames[i]));
    engine->finish();
    const EngineResult r = engine->result();
    ASSERT_TRUE(r.measured) << "guidance bits " << r.guidance_seen;
    EXPECT_EQ(r.views, AnswerViews::front_and_back);
    EXPECT_EQ(r.frames_used, 24U);
    EXPECT_EQ(r.frames_back, 12U);
    EXPECT_GT(r.frames_seen, static_cast<std::uint64_t>(kTurnFirst + kTurnFrames / 2)) << "after the half turn";
    ASSERT_GE(story.states.size(), 3U);
    const std::vector<SessionState> last(story.states.end() - 3, story.states.end());
    EXPECT_EQ(last,
              (std::vector<SessionState>{SessionState::tracking, SessionState::turning, SessionState::measured}));
    bool requested = false;
    int lost = 0;
    for (const EngineResult& frame : story.frames) {
      const bool now = has(frame.guidance, Guidance::turn_round);
      requested = requested || now;
      EXPECT_FALSE(now && frame.state != SessionState::turning) << frame.frames_seen;
      EXPECT_FALSE(now && frame.frames_seen > kTurnFirst + kTurnFrames) << frame.frames_seen;
      if (frame.state == SessionState::turning) {
        EXPECT_TRUE(frame.user == r.user || frame.user == 0) << frame.user << " in " << frame.frames_seen;
        lost += frame.user == 0 ? 1 : 0;
      }
    }
    EXPECT_TRUE(requested);
    EXPECT_LE(lost, 2) << "frames that flicker; the id stays";
    EXPECT_EQ(engine->fused_mask().width, data_->intrinsics.width);
    PersonMeasurement person;
    person.result = r;
    texts[single_thread ? 1 : 0] = result_json(person);
  }
  EXPECT_EQ(texts[0], texts[1]);
}

TEST_F(RealStages, WhoLeavesInsteadOfTurningGetsTheFrontsOwnAnswer) {
  Story story;
  auto engine = make_engine(true, Turn::back, story.watch());
  auto plain = make_engine(true);
  const std::vector<std::uint16_t> empty_room(data_->frames[0].size(), 0);
  std::uint64_t n = 0;
  while (engine->result().state != SessionState::turning && n < kTurnFirst) {
    ASSERT_TRUE(push(*plain, n, data_->turn_frames[n]));
    ASSERT_TRUE(push(*engine, n, data_->turn_frames[n]));
    ++n;
  }
  ASSERT_EQ(engine->result().state, SessionState::turning);
  const EngineResult preliminary = engine->result();
  EXPECT_TRUE(preliminary.front_measured);
  for (int i = 0; i < 40 && !engine->result().measured; ++i) ASSERT_TRUE(push(*engine, n++, empty_room));
  const EngineResult r = engine->result();
  ASSERT_TRUE(r.measured) << "before the end of the stream";
  EXPECT_EQ(r.views, AnswerViews::front);
  EXPECT_EQ(r.frames_used, 12U);
  EXPECT_EQ(r.frames_back, 0U);
  EXPECT_EQ(values_of(r), values_of(preliminary));
  ASSERT_TRUE(plain->result().measured);
  EXPECT_EQ(values_of(r), values_of(plain->result())) << "as if no turn had been requested";
}

TEST_F(RealStages, NothingAllocatesInATurn) {
  auto engine = make_engine(false, Turn::back);
  test::arm_allocation_count();
  bool pushed = true;
  for (int person = 0; person < 2; ++person) {
    for (std::uint64_t i = 0; i < kTurnClipFrames; ++i)
      pushed = static_cast<bool>(push(*engine, i, data_->turn_frames[i])) && pushed;
    engine->finish();
    if (person == 0) engine->reset();
  }
  const long allocations = test::disarm_allocation_count();
  EXPECT_EQ(allocations, 0);
  EXPECT_TRUE(pushed);
  EXPECT_EQ(engine->result().views, AnswerViews::front_and_back);
}

// All round, with an index that knows shapes; what the answer is worth: tests/apps/measured_clip_test.cpp.
class AllRound : public RealStages {
 protected:
  void SetUp() override {
    RealStages::SetUp();
    if (IsSkipped()) return;
    const char* path = std::getenv("IM2FIT_INDEX");
    if (path == nullptr) GTEST_SKIP() << "no index: set IM2FIT_INDEX (scripts/test makes one)";
    auto index = index::Index::open(path);
    ASSERT_TRUE(index) << index.error().message;
    index_.emplace(std::move(*index));
    const lab::Subject subject = lab::draw_subject(data_->model, lab::Family::training, 5, 2);
    lab::SceneOptions options;
    options.rotate_deg = kRotateDeg;
    options.pose = lab::StandingPose::arms_out;
    options.step_round = {kTurnFirst, 6, 360};
    frames_ = rendered(subject, options, kTurnFirst + 6 * 30 + 20);
  }
  Result<std::unique_ptr<Engine>> make(const body::BodyModel* body) {
    EngineSettings settings;
    settings.width = data_->intrinsics.width;
    settings.height = data_->intrinsics.height;
    settings.intrinsics = data_->intrinsics;
    settings.frames_wanted = 12;
    settings.turn = Turn::around;
    settings.shape_space = &data_->model.shape_space();
    settings.body = body;
    return Engine::create(settings, *data_->tracker, *index_);
  }
  std::optional<index::Index> index_;
  std::vector<std::vector<std::uint16_t>> frames_;
};

TEST_F(AllRound, NothingAllocatesAndTheSamePersonIsMeasuredTheSameAgain) {
  auto engine = make(&data_->model);
  ASSERT_TRUE(engine) << engine.error().message;
  std::array<EngineResult, 2> results;
  bool pushed = true;
  test::arm_allocation_count();
  for (EngineResult& result : results) {
    for (std::uint64_t i = 0; i < frames_.size(); ++i)
      pushed = static_cast<bool>(push(**engine, i, frames_[i])) && pushed;
    (*engine)->finish();
    result = (*engine)->result();
    (*engine)->reset();
  }
  const long allocations = test::disarm_allocation_count();
  EXPECT_EQ(allocations, 0);
  EXPECT_TRUE(pushed);
  EXPECT_EQ(results[0].views, AnswerViews::around);
  EXPECT_GE(std::fabs(results[0].turned_deg), 330);
  EXPECT_EQ(values_of(results[0]), values_of(results[1]));
}

TEST_F(AllRound, WithoutTheBodyFileItIsRefused) {
  const auto engine = make(nullptr);
  ASSERT_FALSE(engine);
  EXPECT_NE(engine.error().message.find("all round"), std::string::npos) << engine.error().message;
}

}  // namespace
}  // namespace im2fit
