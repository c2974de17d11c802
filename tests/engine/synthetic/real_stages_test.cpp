// SPDX-License-Identifier: Apache-2.0
// The engine on its real stages: a rendered person, the trained tracker, and an index of random people made here.
// What the index answers means nothing; that the same frames give the same bytes and that nothing allocates does.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <optional>

#include "allocations.h"
#include "base/file.h"
#include "base/rng.h"
#include "body/params_vector.h"
#include "engine/avatar.h"
#include "engine/engine.h"
#include "engine/result_json.h"
#include "hal/source.h"
#include "index/builder.h"
#include "synth/population.h"
#include "synth/virtual_camera.h"

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
constexpr int kSensorWidth = 320;
constexpr int kSensorHeight = 240;
constexpr int kRotateDeg = 90;

Result<index::Index> random_index(std::size_t modifier_count) {
  index::BuildOptions options;
  options.dimensions = 4;
  options.population_version = body::kPopulationVersion;
  std::vector<index::Sample> samples;
  Rng rng(9);
  for (std::uint64_t i = 0; i < 40; ++i) {
    index::Sample sample;
    sample.subject = i;
    sample.feature.resize(kFeatureSize);
    for (float& f : sample.feature) f = static_cast<float>(rng.normal());
    for (float& t : sample.truth) t = static_cast<float>(rng.normal(1000, 50));
    sample.truth[measurement_index(Measurement::stature)] = static_cast<float>(rng.normal(1700, 60));
    sample.truth[measurement_index(Measurement::weight)] = static_cast<float>(rng.normal(70, 8));
    sample.woman = i % 2 == 1;
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
    data_ = new Data{std::move(*model), std::move(*bytes), {}, {}, {}, {}};
    auto tracker = JointModel::parse(data_->tracker_bytes, tracker_path);
    ASSERT_TRUE(tracker) << tracker.error().message;
    data_->tracker.emplace(std::move(*tracker));
    auto index = random_index(data_->model.modifier_names().size());
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
    const Intrinsics sensor = synth::kinect_intrinsics(kSensorWidth, kSensorHeight);
    const synth::Subject subject = synth::draw_subject(data_->model, synth::Family::training, 5, 2);
    synth::SceneOptions options;
    options.rotate_deg = kRotateDeg;
    synth::VirtualScene scene(data_->model, subject, options, {}, sensor, 5);
    std::vector<std::uint16_t> landscape(static_cast<std::size_t>(kSensorWidth) * kSensorHeight);
    const DepthImage in(landscape.data(), kSensorWidth, kSensorHeight);
    for (std::uint64_t i = 0; i < kFrameCount; ++i) {
      scene.render(i, in);
      data_->frames.emplace_back(landscape.size());
      hal::rotate_upright(in, kRotateDeg, {data_->frames.back().data(), kSensorHeight, kSensorWidth});
    }
    data_->intrinsics = synth::upright_intrinsics(sensor, kRotateDeg);
  }

  static std::unique_ptr<Engine> make_engine(bool single_thread) {
    EngineSettings settings;
    settings.width = data_->intrinsics.width;
    settings.height = data_->intrinsics.height;
    settings.intrinsics = data_->intrinsics;
    settings.frames_wanted = 12;
    settings.single_thread = single_thread;
    auto engine = Engine::create(settings, *data_->tracker, *data_->index);
    EXPECT_TRUE(engine) << engine.error().message;
    return std::move(*engine);
  }

  static Status push(Engine& engine, std::uint64_t i) {
    hal::FrameInfo info;
    info.sequence = i;
    info.host_ns = static_cast<std::int64_t>(i + 1) * 33333333;
    return engine.push({data_->frames[i % kFrameCount].data(), data_->intrinsics.width, data_->intrinsics.height},
                       info);
  }

  struct Data {
    body::BodyModel model;
    std::vector<std::byte> tracker_bytes;
    std::optional<JointModel> tracker;
    std::optional<index::Index> index;
    std::vector<std::vector<std::uint16_t>> frames;
    Intrinsics intrinsics;
  };
  static inline Data* data_ = nullptr;
};

TEST_F(RealStages, MeasureWithTheSameBytesOnOneAndTwoThreadsAndTwice) {
  std::string texts[3];
  for (int run = 0; run < 3; ++run) {
    auto engine = make_engine(run == 1);
    for (std::uint64_t i = 0; i < kFrameCount; ++i) ASSERT_TRUE(push(*engine, i));
    engine->finish();
    ResultReport report;
    report.result = engine->result();
    ASSERT_TRUE(report.result.measured) << "guidance bits " << report.result.guidance_seen;
    EXPECT_EQ(engine->fused_mask().width, data_->intrinsics.width);
    report.source.intrinsics = data_->intrinsics;
    const auto& a = report.result.answer;
    report.size = size_probabilities(builtin_size_system(),
                                     a.measurements[measurement_index(Measurement::chest_girth)], a.female);
    auto answered =
        body_of_answer(data_->model, *data_->index, a, report.result.measured_joints, report.result.floor);
    ASSERT_TRUE(answered) << answered.error().message;
    report.body = answered->params;
    report.modifier_names = data_->model.modifier_names();
    texts[run] = result_json(report);
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

}  // namespace
}  // namespace im2fit
