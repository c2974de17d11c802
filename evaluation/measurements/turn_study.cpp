// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/turn_study.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "body/fit/measurement_fit.h"
#include "body/fit/nearest_start.h"
#include "body/fit/point_mesh.h"
#include "body/fit/shape_fitter.h"
#include "body/fit/turn_fitter.h"
#include "body/measure.h"
#include "body/model_data.h"
#include "body/start_bodies.h"
#include "body/tape.h"
#include "core/rng.h"
#include "estimate/turned_values.h"
#include "evaluation/measurements/error_statistics.h"
#include "evaluation/population/other_tape.h"
#include "hal/source.h"
#include "perception/observe/observe.h"
#include "person/builtin_tape.h"
#include "train/camera/virtual_camera.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kTurnStream = 0x7024E;
constexpr int kFrontFrames = 45;  // shown of the front before the first step
constexpr int kFollowEach = 3;    // ten pictures a second
constexpr float kShortDeg = 3;    // a turn is followed to within 2 degrees

struct Keyframe {
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
};

class TurnSession {
 public:
  TurnSession(const body::BodyModel& model, const JointModel& joint_model, const TurnStudyOptions& options)
      : model_(model),
        options_(options),
        joint_model_(joint_model),
        fitter_(model.shape_space()),
        turn_(model.shape_space()),
        mesh_(model),
        measurer_(model),
        one_body_(model),
        tape_(model) {}

  TurnOutcome run(std::uint64_t index);

 private:
  bool fit_front(VirtualScene& scene, const HeldOutPerson& person, TurnOutcome& outcome);
  void follow(VirtualScene& scene, const HeldOutPerson& person, int frames, TurnOutcome& outcome);
  void measure(const HeldOutPerson& person, TurnOutcome& outcome);
  void compare_limbs(const HeldOutPerson& person, const body::TurnFit& fit, std::span<const Vec3f> mesh,
                     TurnOutcome& outcome);
  std::optional<ActorLevels> true_levels(const HeldOutPerson& person) const;
  void compare_levels(const ActorLevels& levels, TurnOutcome& outcome) const;
  Detection take(VirtualScene& scene, const HeldOutPerson& person, std::uint64_t frame);
  void keep(ImageView<const std::uint16_t> depth, float unit_mm, MaskView mask, const body::Pose& pose);

  const body::BodyModel& model_;
  const TurnStudyOptions& options_;
  const JointModel& joint_model_;
  body::ShapeFitter fitter_;
  body::TurnFitter turn_;
  body::PointMesh mesh_;
  body::Measurer measurer_;
  body::MeasurementFitter one_body_;
  body::TapeMeasurer tape_;

  Intrinsics upright_;
  std::unique_ptr<PersonDetector> detector_;
  std::unique_ptr<Fuser> fuser_;
  std::vector<std::uint16_t> delivered_, picture_;
  std::vector<std::uint8_t> mask_;
  std::vector<Keyframe> kept_;
  std::vector<body::TurnView> views_;
  body::PersonAxes axes_;
};

Detection TurnSession::take(VirtualScene& scene, const HeldOutPerson& person, std::uint64_t frame) {
  const Intrinsics& k = person.capture.intrinsics;
  const DepthImage delivered(delivered_.data(), k.width, k.height);
  scene.render(frame, delivered);
  hal::rotate_upright(delivered, person.capture.scene.rotate_deg,
                      DepthImage(picture_.data(), upright_.width, upright_.height));
  return detector_->sense(DepthView(picture_.data(), upright_.width, upright_.height), upright_,
                          MaskImage(mask_.data(), upright_.width, upright_.height));
}

void TurnSession::keep(ImageView<const std::uint16_t> depth, float unit_mm, MaskView mask, const body::Pose& pose) {
  Keyframe& kept = kept_.emplace_back();
  for (int v = 0; v < depth.height; ++v) {
    kept.depth.insert(kept.depth.end(), depth.row(v), depth.row(v) + depth.width);
    kept.mask.insert(kept.mask.end(), mask.row(v), mask.row(v) + mask.width);
  }
  views_.push_back({{{kept.depth.data(), depth.width, depth.height},
                     unit_mm,
                     {kept.mask.data(), mask.width, mask.height},
                     upright_},
                    pose});
}

bool TurnSession::fit_front(VirtualScene& scene, const HeldOutPerson& person, TurnOutcome& outcome) {
  for (int f = 0; f < kFrontFrames; ++f) {
    const Detection detection = take(scene, person, static_cast<std::uint64_t>(f));
    if (detection.guidance != 0 || !detection.person.found || detection.view != ViewSide::front) continue;
    fuser_->add(DepthView(picture_.data(), upright_.width, upright_.height),
                MaskView(mask_.data(), upright_.width, upright_.height), upright_, detection);
  }
  if (fuser_->frame_count() < kCaptureFramesMin) return false;
  const Fuser::Description& seen = fuser_->describe();
  if (!seen.valid) return false;
  const std::array<body::FitView, 1> views = {
      body::FitView{fuser_->depth_q4(), fuser_->mask(), upright_, seen.joints, seen.floor}};
  const body::ShapeFit& fit = fitter_.run(views);
  if (!fit.valid) return false;
  axes_ = body::PersonAxes(seen.joints, seen.floor);
  turn_.begin(std::span(fit.shape).first(model_.shape_space().shape_count), fit.pose, axes_, seen.floor.known);
  keep(fuser_->depth_q4(), 1.0F / 16, fuser_->mask(), fit.pose);
  outcome.views_deg.push_back(0);
  return true;
}

void TurnSession::follow(VirtualScene& scene, const HeldOutPerson& person, int frames, TurnOutcome& outcome) {
  // Of a whole turn the last picture stands before the first; of a part it is the end.
  const int gaps = options_.degrees < 360 ? std::max(1, options_.view_count - 1) : options_.view_count;
  const float apart = options_.degrees / static_cast<float>(gaps);
  const StepRoundMotion motion(person.capture.scene.step_round, person.capture.seed);
  double error = 0;
  for (int f = kFrontFrames; f < kFrontFrames + frames; ++f) {
    const Detection detection = take(scene, person, static_cast<std::uint64_t>(f));
    if ((f - kFrontFrames) % kFollowEach != 0) continue;
    ++outcome.frames;
    if (!detection.person.found) {
      ++outcome.frames_without_person;
      continue;
    }
    const body::TurnPicture picture{{picture_.data(), upright_.width, upright_.height},
                                    1,
                                    {mask_.data(), upright_.width, upright_.height},
                                    upright_};
    if (!turn_.follow(picture)) continue;
    ++outcome.frames_followed;
    error += static_cast<double>(std::fabs(turn_.turned_deg() - motion.yaw_deg(static_cast<std::uint64_t>(f))));
    if (static_cast<int>(views_.size()) < options_.view_count &&
        std::fabs(turn_.turned_deg()) >= apart * static_cast<float>(views_.size()) - kShortDeg) {
      outcome.views_deg.push_back(turn_.turned_deg());
      keep(picture.depth, 1, picture.mask, turn_.pose());
    }
  }
  outcome.true_turn_deg = motion.yaw_deg(static_cast<std::uint64_t>(kFrontFrames + frames));
  outcome.turned_deg = turn_.turned_deg();
  outcome.yaw_error_deg = static_cast<float>(error / std::max(1, outcome.frames_followed));
}

void TurnSession::measure(const HeldOutPerson& person, TurnOutcome& outcome) {
  const body::TurnFit& fit = turn_.run(views_);
  if (!fit.valid) return;
  for (std::size_t v = 0; v < views_.size(); ++v)
    outcome.surface_mm += fit.surface_mm[v] / static_cast<float>(views_.size());
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model_.vertex_count()));
  body::Params params;
  params.gender = outcome.woman ? 0.0F : 1.0F;
  model_.morph(params, mesh);
  mesh_.run(fit.points, fit.bones, mesh);
  outcome.measured_values = measure_turned(model_, measurer_, mesh, outcome.woman).values;
  outcome.measured = true;
  compare_limbs(person, fit, mesh, outcome);
  measurer_.measure_rest_mesh(mesh, params.gender);
  if (const auto levels = true_levels(person)) compare_levels(*levels, outcome);
}

std::array<float, kTurnLimbCount> limbs_among(std::span<const float> tape_values) {
  std::array<float, kTurnLimbCount> out{};
  for (std::size_t i = 0; i < kTurnLimbCount; ++i)
    out[i] = tape_values[static_cast<std::size_t>(definition_index(builtin_tape(), kTurnLimbs[i]))];
  return out;
}

// The largest standard deviations that the product's intervals have of what a turn measures.
constexpr float kOneBodySdMm = 15;

void TurnSession::compare_limbs(const HeldOutPerson& person, const body::TurnFit& fit, std::span<const Vec3f> mesh,
                                TurnOutcome& outcome) {
  const body::Tape& tape = builtin_tape();
  std::vector<float> values(tape.definitions.size());
  const float gender = outcome.woman ? 0.0F : 1.0F;
  if (person.subject.actor != nullptr && options_.people.other != nullptr) {
    const LimbGirths truth = limb_girths_of(*person.subject.actor, options_.people.other->rig().parts);
    outcome.true_limbs = {static_cast<float>(truth.mid_thigh), static_cast<float>(truth.calf),
                          static_cast<float>(truth.upper_arm)};
  } else {
    std::vector<Vec3f> rest(static_cast<std::size_t>(model_.vertex_count()));
    morph_subject(model_, person.subject, rest);
    tape_.measure_rest_mesh(tape, rest, gender, values);
    outcome.true_limbs = limbs_among(values);
  }
  tape_.measure_rest_mesh(tape, mesh, gender, values);
  outcome.fused_limbs = limbs_among(values);

  body::MeasurementGoals goals;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) goals[m] = {outcome.measured_values[m], kOneBodySdMm};
  const body::StartBodies& starts = model_.start_bodies();
  body::Params params = starts.params(body::nearest_start(starts, outcome.woman, outcome.measured_values));
  const body::SeenBody seen = body::seen_body(fit);
  one_body_.run(params, goals, &seen);
  tape_.measure(tape, params, values);
  outcome.answered_limbs = limbs_among(values);
}

float lowest_y(std::span<const Vec3f> vertices) {
  return std::min_element(vertices.begin(), vertices.end(), [](Vec3f a, Vec3f b) { return a.y < b.y; })->y;
}

// Height of a section of the body measured last, above the floor, mm; NaN: it meets no triangle.
float height_of(const body::Measurer& measurer, const body::BodyModel& model, Measurement id) {
  const float low = lowest_y(measurer.posed().first(static_cast<std::size_t>(model.body_vertex_count())));
  for (const body::Section& section : measurer.sections())
    if (section.id == id && !section.hull.empty()) return section.hull.front().y - low;
  return std::numeric_limits<float>::quiet_NaN();
}

std::optional<ActorLevels> TurnSession::true_levels(const HeldOutPerson& person) const {
  if (person.subject.actor != nullptr) {
    if (options_.people.other == nullptr) return std::nullopt;
    return levels_of(*person.subject.actor, options_.people.other->rig().parts);
  }
  std::vector<Vec3f> rest(static_cast<std::size_t>(model_.vertex_count()));
  morph_subject(model_, person.subject, rest);
  body::Measurer measurer(model_);
  measurer.measure_rest_mesh(rest, person.subject.woman ? 0.0F : 1.0F);
  return ActorLevels{height_of(measurer, model_, Measurement::chest_girth),
                     height_of(measurer, model_, Measurement::waist_girth),
                     height_of(measurer, model_, Measurement::hip_girth)};
}

// Of the body measured last.
void TurnSession::compare_levels(const ActorLevels& levels, TurnOutcome& outcome) const {
  const auto posed = measurer_.posed();
  const float low = lowest_y(posed.first(static_cast<std::size_t>(model_.body_vertex_count())));
  std::vector<std::uint8_t> trunk;
  for (const std::uint8_t arm : model_.data().triangle_is_arm) trunk.push_back(arm == 0 ? 1 : 0);
  const std::array<std::pair<Measurement, float>, 3> sections = {{{Measurement::chest_girth, levels.chest},
                                                                  {Measurement::waist_girth, levels.waist},
                                                                  {Measurement::hip_girth, levels.hip}}};
  for (std::size_t l = 0; l < sections.size(); ++l) {
    const auto [id, height] = sections[l];
    outcome.level_error_mm[l] = height_of(measurer_, model_, id) - height;
    outcome.at_true_level_mm[l] =
        static_cast<float>(tape_round(posed, model_.body_triangles(), trunk, {0, low + height, 0}, {0, 1, 0})) -
        outcome.truth[measurement_index(id)];
  }
  outcome.has_levels = true;
}

TurnOutcome TurnSession::run(std::uint64_t index) {
  HeldOutPerson person = draw_person(model_, options_.people, index);
  Rng rng = Rng::for_item(options_.people.seed, kTurnStream, index);
  SceneOptions& scene_options = person.capture.scene;
  scene_options.step_round = {kFrontFrames,
                              static_cast<float>(rng.uniform(static_cast<double>(options_.seconds_min),
                                                             static_cast<double>(options_.seconds_max))) *
                                  std::fabs(options_.degrees) / 360,
                              options_.degrees};
  const int frames = static_cast<int>(scene_options.step_round.seconds * 30) + 30;
  VirtualScene scene(model_, person.subject, scene_options, person.capture.sensor, person.capture.intrinsics,
                     person.capture.seed);
  upright_ = hal::rotate_upright(person.capture.intrinsics, scene_options.rotate_deg);
  const auto pixels = static_cast<std::size_t>(upright_.width) * static_cast<std::size_t>(upright_.height);
  delivered_.resize(pixels);
  picture_.resize(pixels);
  mask_.resize(pixels);
  detector_ = std::make_unique<PersonDetector>(upright_.width, upright_.height, joint_model_);
  fuser_ = std::make_unique<Fuser>(upright_.width, upright_.height);
  kept_.clear();
  kept_.reserve(body::kTurnViewMax);
  views_.clear();

  TurnOutcome outcome;
  outcome.woman = person.subject.woman;
  outcome.truth = person.subject.truth;
  outcome.measured_values.fill(std::numeric_limits<float>::quiet_NaN());
  outcome.front_found = fit_front(scene, person, outcome);
  if (!outcome.front_found) return outcome;
  follow(scene, person, frames, outcome);
  measure(person, outcome);
  return outcome;
}

}  // namespace

Result<std::vector<TurnOutcome>> study_turns(const body::BodyModel& model, const JointModel& joint_model,
                                             const TurnStudyOptions& options) {
  const auto count = static_cast<std::uint64_t>(options.people.subjects);
  std::vector<TurnOutcome> outcomes(count);
  for_each_item(
      count, options.people.threads,
      [&](std::uint64_t i) { outcomes[i] = TurnSession(model, joint_model, options).run(i); },
      begin_progress(options.people.progress, "people who turn", count));
  return outcomes;
}

std::string text_of(const std::vector<TurnOutcome>& outcomes) {
  std::string text;
  int fronts = 0, measured = 0, frames = 0, absent = 0, followed = 0;
  double yaw = 0, surface = 0, closed = 0;
  for (const TurnOutcome& o : outcomes) {
    fronts += o.front_found ? 1 : 0;
    frames += o.frames;
    absent += o.frames_without_person;
    followed += o.frames_followed;
    if (!o.measured) continue;
    ++measured;
    yaw += static_cast<double>(o.yaw_error_deg);
    surface += static_cast<double>(o.surface_mm);
    closed += static_cast<double>(std::fabs(std::fabs(o.turned_deg) - std::fabs(o.true_turn_deg)));
  }
  const double n = std::max(1, measured);
  text += fmt::format("{} people, {} fronts fitted, {} measured\n", outcomes.size(), fronts, measured);
  text += fmt::format("of {} pictures {} without the person, {} not followed\n", frames, absent,
                      frames - absent - followed);
  text += fmt::format("yaw error {:.1f} deg, turn error {:.1f} deg, surface {:.1f} mm\n", yaw / n, closed / n,
                      surface / n);
  text += "measurement                 people    bias     MAE     p95\n";
  const auto add_line = [&](std::string_view what, const std::vector<double>& errors) {
    const ErrorStatistics s = error_statistics(errors);
    if (s.count > 0)
      text += fmt::format("{:<27} {:>6} {:>7.1f} {:>7.1f} {:>7.1f}\n", what, s.count, s.bias, s.mae, s.p95);
  };
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    std::vector<double> errors;
    for (const TurnOutcome& o : outcomes)
      if (o.measured) errors.push_back(static_cast<double>(o.measured_values[m] - o.truth[m]));
    add_line(kMeasurementTable[m].id, errors);
  }
  const auto add_limbs = [&](const char* of, const auto& values_of) {
    for (std::size_t l = 0; l < kTurnLimbCount; ++l) {
      std::vector<double> errors;
      for (const TurnOutcome& o : outcomes)
        if (o.measured) errors.push_back(static_cast<double>(values_of(o)[l] - o.true_limbs[l]));
      add_line(fmt::format("{}{}", kTurnLimbs[l], of), errors);
    }
  };
  add_limbs("", [](const TurnOutcome& o) { return o.fused_limbs; });
  add_limbs(", one body", [](const TurnOutcome& o) { return o.answered_limbs; });
  constexpr std::array<const char*, 3> kLevels = {"chest", "waist", "hip"};
  const auto add_levels = [&](const char* what, const auto& values_of) {
    for (std::size_t l = 0; l < kLevels.size(); ++l) {
      std::vector<double> errors;
      for (const TurnOutcome& o : outcomes)
        if (o.has_levels) errors.push_back(static_cast<double>(values_of(o)[l]));
      add_line(fmt::format("{} {}", kLevels[l], what), errors);
    }
  };
  add_levels("height", [](const TurnOutcome& o) { return o.level_error_mm; });
  add_levels("at true height", [](const TurnOutcome& o) { return o.at_true_level_mm; });
  return text;
}

}  // namespace im2fit::lab
