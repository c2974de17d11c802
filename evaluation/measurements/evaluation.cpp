// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/evaluation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include "body/fatness.h"
#include "body/measure.h"
#include "core/rng.h"
#include "evaluation/measurements/session.h"
#include "train/camera/synthetic_person.h"
#include "train/common/parallel.h"
#include "train/dataset/features.h"
#include "train/dressed/dressed_people.h"
#include "train/population/ood_subjects.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kSceneStream = 0x5CE9E;
constexpr std::uint64_t kSecondSceneStream = 0x5CE9F;
constexpr std::uint64_t kClothesStream = 0xC107;
constexpr std::uint64_t kGarmentsStream = 0xC108;
constexpr std::uint64_t kKnownStream = 0x4F0;
constexpr float kWithinMm = 100.0F;

void dress(SceneOptions& scene, std::uint64_t seed, std::uint64_t index) {
  constexpr Clothing kWorn[] = {Clothing::tight, Clothing::normal, Clothing::loose};
  Rng rng = Rng::for_item(seed, kClothesStream, index);
  scene.clothing = kWorn[rng.index(3)];
  scene.hair = true;
}

void dress_in_garments(SceneOptions& scene, const body::BodyModel& model, bool woman, std::uint64_t seed,
                       std::uint64_t index) {
  Rng rng = Rng::for_item(seed, kGarmentsStream, index);
  scene.clothing = Clothing::garments;
  scene.hair = true;
  scene.dresser = dresser_of(model, woman, draw_garments(rng));
}

float body_mass_index(const Subject& subject) {
  const float metres = subject.truth[measurement_index(Measurement::stature)] * 1e-3F;
  return subject.truth[measurement_index(Measurement::weight)] / (metres * metres);
}

// The first who is heavy enough of those who could stand in for the subject of this index.
Subject heavy_enough(const body::BodyModel& model, const EvaluationOptions& options, std::uint64_t index,
                     Subject subject) {
  constexpr std::uint64_t kDrawsMax = 2000;
  for (std::uint64_t draw = 1; draw < kDrawsMax && body_mass_index(subject) < options.body_mass_index_min; ++draw) {
    // An even number of steps: men stay men.
    const auto other = index + 2 * draw * static_cast<std::uint64_t>(options.subjects);
    subject = draw_subject(model, Family::held_out, options.seed, other);
  }
  return subject;
}

// The trunk's modifiers among those of body/fatness.h, in one direction until the waist has grown by that much.
void grow_waist(const body::BodyModel& model, float by_mm, Subject& subject) {
  constexpr std::string_view kTrunk[] = {"torso/torso-scale-horiz", "torso/torso-scale-depth",
                                         "stomach/stomach-pregnant"};
  constexpr std::size_t kWaist = measurement_index(Measurement::waist_girth);
  constexpr int kSteps = 4;
  const float goal_mm = subject.truth[kWaist] + by_mm;
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  subject.params.modifiers.resize(model.modifier_names().size());
  float step = 0.05F;  // a few centimetres of most waists
  for (int i = 0; i < kSteps; ++i) {
    for (const body::FatnessPart& part : body::kFatness)
      if (std::find(std::begin(kTrunk), std::end(kTrunk), part.modifier) != std::end(kTrunk))
        if (const int m = model.modifier_index(part.modifier); m >= 0)
          subject.params.modifiers[static_cast<std::size_t>(m)] += step * part.share;
    const float before_mm = subject.truth[kWaist];
    morph_subject(model, subject, rest);
    subject.truth = body::measure_rest_mesh(model, rest, subject.params.gender);
    const float grown_mm = subject.truth[kWaist] - before_mm;
    if (grown_mm == 0) return;
    step *= (goal_mm - subject.truth[kWaist]) / grown_mm;
  }
}

KnownFacts reported_facts(const EvaluationOptions& options, const Subject& subject, std::uint64_t index) {
  KnownFacts facts;
  if (options.known == KnownOf::nothing) return facts;
  Rng rng = Rng::for_item(options.seed, kKnownStream, index);
  const auto off_by = [&](float sd) { return sd * static_cast<float>(rng.normal()); };
  const bool all = options.known == KnownOf::all;
  const float weight_kg = subject.truth[measurement_index(Measurement::weight)] +
                          (index / 2 % 2 == 0 ? options.known_weight_off_kg : -options.known_weight_off_kg);
  // What no device takes is not reported.
  const auto allowed = [](float kg) {
    return std::clamp(kg, static_cast<float>(kKnownWeightKg.least), static_cast<float>(kKnownWeightKg.most));
  };
  if (options.known == KnownOf::weight_on_scale)
    facts.weight_kg = {allowed(weight_kg + off_by(kScaleSdKg)), kScaleSdKg};
  else
    facts.weight_kg = {allowed(std::round(weight_kg + off_by(kStatedWeightSdKg))), kStatedWeightSdKg};
  if (!all) return facts;
  const float stature_mm = subject.truth[measurement_index(Measurement::stature)];
  facts.stature_mm = {10 * std::round((stature_mm + off_by(kStatedStatureSdMm)) / 10), kStatedStatureSdMm};
  facts.sex = subject.woman ? KnownSex::woman : KnownSex::man;
  facts.age_years = {age_of_completed_years(std::floor(subject.params.age_years)), kStatedAgeSdYears};
  return facts;
}

void add_joint_errors(const JointSet& found, const JointSet& truth, Outcome& outcome) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const float error_mm = norm(found.position_mm[j] - truth.position_mm[j]);
    ++outcome.joint_count;
    outcome.joint_error_sum_mm += error_mm;
    if (error_mm <= kWithinMm) ++outcome.joints_within_100mm;
  }
}

Status measure_once(const SessionModels& models, const HeldOutPerson& person, Views views, Outcome& outcome) {
  outcome.family = person.family;
  outcome.woman = person.subject.woman;
  outcome.truth = person.subject.truth;
  outcome.true_age_years = person.subject.params.age_years;
  const auto engine = run_session(models, person, views, [&](const JointSet& found, const JointSet& truth) {
    add_joint_errors(found, truth, outcome);
  });
  if (!engine) return engine.error();
  if (auto ok = (*engine)->set_known(person.known, (*engine)->result().session); !ok) return ok.error();
  const EngineResult result = (*engine)->result();
  outcome.known = result.known_outcome;
  outcome.dressed = person.capture.scene.clothing != Clothing::none;
  outcome.lifted_arms = told_to_lift_arms(result, person.capture.frame_count);
  outcome.measured = result.measured;
  outcome.guidance_seen = result.guidance_seen;
  outcome.frames_seen = result.frames_seen;
  outcome.answer = result.answer;
  outcome.age = result.age;
  outcome.paper = result.paper;
  return Ok{};
}

Status measure_again(const SessionModels& models, const HeldOutPerson& person, Views views, Outcome& outcome) {
  const auto engine = run_session(models, person, views, {});
  if (!engine) return engine.error();
  if (auto ok = (*engine)->set_known(person.known, (*engine)->result().session); !ok) return ok.error();
  const EngineResult result = (*engine)->result();
  outcome.measured_again = result.measured;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) outcome.again[m] = result.answer.measurements[m].value;
  return Ok{};
}

Result<Outcome> outcome_of(const SessionModels& models, const index::RawNearest* raw,
                           const EvaluationOptions& options, std::uint64_t index) {
  Outcome outcome;
  const HeldOutPerson person = draw_person(models.body, options, index);
  if (auto ok = measure_once(models, person, options.views, outcome); !ok) return ok.error();
  if (options.twice) {
    HeldOutPerson again = draw_person(models.body, options, index, 1);
    if (options.second_waist_mm != 0 && !again.subject.actor)
      grow_waist(models.body, options.second_waist_mm, again.subject);
    if (auto ok = measure_again(models, again, options.views, outcome); !ok) return ok.error();
  }
  if (raw != nullptr && outcome.measured && options.views == Views::front) {
    // The engine keeps its feature to itself; the same frames through the same path give it again.
    CaptureRig rig(models.body, models.joints);
    const Capture& capture = rig.run(person.subject, person.capture);
    outcome.has_raw = capture.valid;
    if (capture.valid) outcome.raw = raw->nearest(capture.feature);
  }
  return outcome;
}

}  // namespace

Result<PeopleFamily> people_family_of(std::string_view name) {
  for (std::size_t i = 0; i < kPeopleFamilyNames.size(); ++i)
    if (kPeopleFamilyNames[i] == name) return static_cast<PeopleFamily>(i);
  return Error{ErrorCode::invalid_argument,
               "no family '" + std::string(name) + "'; there are modifiers, ansur, mixed, other and unlike"};
}

HeldOutPerson draw_person(const body::BodyModel& model, const EvaluationOptions& options, std::uint64_t index,
                          int showing) {
  HeldOutPerson person{{},
                       {},
                       options.smoothed,
                       options.sensor_reported,
                       options.clothing_reported,
                       options.family,
                       options.camera_scale,
                       options.edges,
                       options.tremor_deg,
                       options.poses_told};
  // A man and a woman of each.
  if (options.family == PeopleFamily::mixed)
    person.family = index / 2 % 2 == 0 ? PeopleFamily::ansur : PeopleFamily::modifiers;
  if (person.family == PeopleFamily::other) {
    person.subject = options.other->draw(options.seed, index);
  } else if (person.family == PeopleFamily::ansur) {
    std::vector<Vec3f> rest;
    person.subject = options.ansur->draw(options.seed, index, rest);
  } else if (person.family == PeopleFamily::unlike) {
    person.subject = draw_ood_subject(model, options.seed, index);
  } else {
    person.subject = draw_subject(model, Family::held_out, options.seed, index);
  }
  auto& scene = person.capture.scene;
  scene = options.noise ? furnished_room() : SceneOptions{};
  scene.pose = options.pose;
  if (options.body_mass_index_min > 0)
    person.subject = heavy_enough(model, options, index, std::move(person.subject));
  person.known = reported_facts(options, person.subject, index);
  if (options.clothed && options.garments)
    dress_in_garments(scene, model, person.subject.woman, options.seed, index);
  else if (options.clothed)
    dress(scene, options.seed, index);
  if (options.distance_mm > 0) {
    scene.distance_mm = options.distance_mm;
    scene.enlarge_to_fit = true;
  }
  // Even and odd people are men and women: every other one of each turns to the other side.
  if (options.yaw_deg >= 0) scene.yaw_deg = index / 2 % 2 == 0 ? options.yaw_deg : -options.yaw_deg;
  person.capture.sensor = options.tof ? tof_sensor() : sensor_of(options.noise);
  person.capture.intrinsics = kinect_intrinsics(options.width, options.height);
  person.capture.frame_count = options.frames;
  const std::uint64_t stream = showing == 0 ? kSceneStream : kSecondSceneStream;
  person.capture.seed = Rng::for_item(options.seed, stream, index).next();
  return person;
}

Result<std::vector<Outcome>> evaluate(const body::BodyModel& model, const JointModel& joint_model,
                                      const index::Index& index, const index::RawNearest* raw,
                                      const EvaluationOptions& options, const std::string& what) {
  const SessionModels models{model, joint_model, index, options.fit ? &model.shape_space() : nullptr};
  const auto count = static_cast<std::uint64_t>(options.subjects);
  std::vector<Outcome> outcomes(count);
  std::mutex mutex;
  std::optional<Error> failure;
  for_each_item(
      count, options.threads,
      [&](std::uint64_t i) {
        auto outcome = outcome_of(models, raw, options, i);
        if (outcome) {
          outcomes[i] = *outcome;
          return;
        }
        const std::lock_guard lock(mutex);
        failure = outcome.error();
      },
      begin_progress(options.progress, what, count));
  if (failure) return *failure;
  return outcomes;
}

}  // namespace im2fit::lab
