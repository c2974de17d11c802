// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit-lab/evaluation.h"

#include <mutex>
#include <optional>

#include "apps/common/synthetic_person.h"
#include "apps/im2fit-lab/parallel.h"
#include "base/rng.h"
#include "synth/features.h"

namespace im2fit::apps {
namespace {

constexpr std::uint64_t kSceneStream = 0x5CE9E;
constexpr int kShownPerWanted = 3;
constexpr float kWithinMm = 100.0F;

using Person = HeldOutPerson;

}  // namespace

HeldOutPerson draw_person(const body::BodyModel& model, const EvaluationOptions& options, std::uint64_t index) {
  Person person{synth::draw_subject(model, synth::Family::held_out, options.seed, index), {}};
  person.capture.scene = options.noise ? furnished_room() : synth::SceneOptions{};
  person.capture.sensor = sensor_of(options.noise);
  person.capture.intrinsics = synth::kinect_intrinsics(options.width, options.height);
  person.capture.frame_count = options.frames;
  person.capture.seed = Rng::for_item(options.seed, kSceneStream, index).next();
  return person;
}

namespace {

void add_joint_errors(const JointSet& found, const JointSet& truth, Outcome& outcome) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const float error_mm = norm(found.position_mm[j] - truth.position_mm[j]);
    ++outcome.joint_count;
    outcome.joint_error_sum_mm += error_mm;
    if (error_mm <= kWithinMm) ++outcome.joints_within_100mm;
  }
}

// Shows frames until the engine has measured or the person has stood there long enough.
Status run_session(Engine& engine, synth::VirtualScene& scene, int rotate_deg, int frames_shown, Outcome& outcome) {
  const Intrinsics k = scene.intrinsics();
  const Intrinsics upright_k = hal::rotate_upright(k, rotate_deg);
  std::vector<std::uint16_t> delivered(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  std::vector<std::uint16_t> upright(delivered.size());
  const DepthImage sensor_image(delivered.data(), k.width, k.height);
  const DepthImage image(upright.data(), upright_k.width, upright_k.height);
  for (int i = 0; i < frames_shown && !engine.result().measured; ++i) {
    scene.render(static_cast<std::uint64_t>(i), sensor_image);
    hal::rotate_upright(sensor_image, rotate_deg, image);
    hal::FrameInfo info;
    info.sequence = static_cast<std::uint64_t>(i);
    info.host_ns = i * 33'333'333LL;
    if (auto pushed = engine.push(image, info); !pushed) return pushed;
    const EngineResult now = engine.result();
    if (now.has_joints) add_joint_errors(now.joints, scene.joints(static_cast<std::uint64_t>(i)), outcome);
  }
  engine.finish();
  return Ok{};
}

Result<Outcome> measure_person(const body::BodyModel& model, const JointModel& joint_model, const index::Index& index,
                               const Person& person) {
  Outcome outcome;
  outcome.woman = person.subject.woman;
  outcome.truth = person.subject.truth;
  const auto& capture = person.capture;
  synth::VirtualScene scene(model, person.subject, capture.scene, capture.sensor, capture.intrinsics, capture.seed);
  EngineSettings settings;
  settings.intrinsics = hal::rotate_upright(capture.intrinsics, capture.scene.rotate_deg);
  settings.width = settings.intrinsics.width;
  settings.height = settings.intrinsics.height;
  settings.frames_wanted = capture.frame_count;
  settings.single_thread = true;
  auto engine = Engine::create(settings, joint_model, index);
  if (!engine) return engine.error();
  const auto shown =
      run_session(**engine, scene, capture.scene.rotate_deg, capture.frame_count * kShownPerWanted, outcome);
  if (!shown) return shown.error();
  const EngineResult result = (*engine)->result();
  outcome.measured = result.measured;
  outcome.guidance_seen = result.guidance_seen;
  outcome.frames_seen = result.frames_seen;
  outcome.answer = result.answer;
  outcome.paper = result.paper;
  return outcome;
}

}  // namespace

Result<std::vector<Outcome>> evaluate(const body::BodyModel& model, const JointModel& joint_model,
                                      const index::Index& index, const index::RawNearest* raw,
                                      const EvaluationOptions& options) {
  const auto count = static_cast<std::uint64_t>(options.subjects);
  std::vector<Outcome> outcomes(count);
  std::mutex mutex;
  std::optional<Error> failure;
  parallel_items("people", count, options.threads, [&](std::uint64_t i) {
    const Person person = draw_person(model, options, i);
    auto outcome = measure_person(model, joint_model, index, person);
    if (!outcome) {
      const std::lock_guard lock(mutex);
      failure = outcome.error();
      return;
    }
    if (raw != nullptr && outcome->measured) {
      // The engine keeps its feature to itself; the same frames through the same path give it again.
      synth::CaptureRig rig(model, joint_model);
      const synth::Capture& capture = rig.run(person.subject, person.capture);
      outcome->has_raw = capture.valid;
      if (capture.valid) outcome->raw = raw->nearest(capture.feature);
    }
    outcomes[i] = *outcome;
  });
  if (failure) return *failure;
  return outcomes;
}

}  // namespace im2fit::apps
