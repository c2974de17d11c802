// SPDX-License-Identifier: Apache-2.0
#include "evaluation/study/simulated_site.h"

#include <fmt/core.h>

#include <cmath>
#include <mutex>
#include <optional>

#include "core/rng.h"
#include "evaluation/measurements/error_statistics.h"
#include "person/person_measurement.h"
#include "person/size_chart.h"
#include "report/result_json.h"
#include "train/common/parallel.h"

namespace im2fit::lab {
namespace {

constexpr std::uint64_t kTapeStream = 0x7A9E;
constexpr char kCamera[] = "virtual Kinect";

// The label that is right for this chest; "" beyond the chart.
std::string label_of(bool woman, double chest_mm) {
  const SizeChart& chart = woman ? builtin_size_system().women : builtin_size_system().men;
  for (const SizeRow& row : chart.rows)
    if (chest_mm >= static_cast<double>(row.low_mm) && chest_mm < static_cast<double>(row.high_mm)) return row.size;
  return "";
}

// This site's tape reading of a truth, without the tape's own error.
double tape_of(SiteKind kind, std::size_t m, double truth) {
  if (kind != SiteKind::tape) return truth;
  const auto id = static_cast<Measurement>(m);
  if (id == Measurement::stature) return truth + kSimulatedShoesMm;
  if (!is_girth(m)) return truth;
  return truth * kSimulatedTightness + (id == Measurement::waist_girth ? kSimulatedWaistMm : 0);
}

// Rounded as a tape is read: to the millimetre, the weight to 0.1 kg.
double read(double value, std::size_t m) {
  const double steps = kMeasurementTable[m].unit == "kg" ? 10 : 1;
  return std::round(value * steps) / steps;
}

EvaluationOptions options_of(const SimulatedSite& site) {
  EvaluationOptions options;
  options.subjects = site.people;
  options.seed = site.seed;
  options.frames = site.frames;
  options.family = site.kind == SiteKind::people ? PeopleFamily::ansur : PeopleFamily::modifiers;
  options.ansur = site.ansur;
  if (site.kind == SiteKind::camera) options.camera_scale = static_cast<float>(kSimulatedCameraScale);
  return options;
}

Result<SimulatedVisit> visit_of(const SessionModels& models, const SimulatedSite& site,
                                const SiteCalibration* calibration, std::uint64_t i) {
  const HeldOutPerson held_out = draw_person(models.body, options_of(site), i);
  SimulatedVisit visit;
  SitePerson& person = visit.person;
  person.person = fmt::format("p{:04}", i);
  person.woman = held_out.subject.woman;
  person.clothing = "bare";
  person.camera = kCamera;
  visit.age_years = static_cast<double>(held_out.subject.params.age_years);
  Rng rng = Rng::for_item(site.seed, kTapeStream, i);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const double tape = tape_of(site.kind, m, static_cast<double>(held_out.subject.truth[m]));
    person.tape[m].first = read(tape + simulated_tape_error(m) * rng.normal(), m);
    person.tape[m].second = read(tape + simulated_tape_error(m) * rng.normal(), m);
  }
  person.worn_size =
      label_of(held_out.subject.woman,
               static_cast<double>(held_out.subject.truth[measurement_index(Measurement::chest_girth)]));
  auto engine = run_session(models, held_out, Views::front, {});
  if (!engine) return engine.error();
  hal::SourceInfo source;
  source.uri = "synthetic";
  source.name = kCamera;
  source.intrinsics = hal::rotate_upright(held_out.capture.intrinsics, held_out.capture.scene.rotate_deg);
  source.rotate_deg = held_out.capture.scene.rotate_deg;
  visit.intrinsics = source.intrinsics;
  auto measured =
      measurement_of(**engine, {&models.index, &models.body, &builtin_size_system(), nullptr, calibration}, source);
  if (!measured) return measured.error();
  visit.measured = measured->result.measured;
  if (!visit.measured) return visit;
  visit.result_json = result_json(*measured);
  person.answer = measured->result.answer.measurements;
  person.female = static_cast<double>(measured->result.answer.female);
  if (measured->size) person.answered_size = measured->size->best;
  return visit;
}

}  // namespace

double simulated_tape_error(std::size_t measurement) {
  const double limit = iso_20685_limit_mm(static_cast<Measurement>(measurement));
  return limit > 0 ? limit / 2 : 0.2;
}

Result<std::vector<SimulatedVisit>> simulate(const body::BodyModel& model, const JointModel& joints,
                                             const index::Index& index, const SimulatedSite& site,
                                             const SiteCalibration* calibration) {
  SessionModels models{model, joints, index, &model.shape_space()};
  if (calibration != nullptr) models.site = calibration->for_camera(kCamera);
  const auto count = static_cast<std::uint64_t>(site.people);
  std::vector<SimulatedVisit> visits(count);
  std::mutex mutex;
  std::optional<Error> failure;
  for_each_item(
      count, site.threads,
      [&](std::uint64_t i) {
        auto visit = visit_of(models, site, calibration, i);
        if (visit) {
          visits[i] = std::move(*visit);
          return;
        }
        const std::lock_guard lock(mutex);
        failure = visit.error();
      },
      begin_progress(site.progress, "people", count));
  if (failure) return *failure;
  return visits;
}

}  // namespace im2fit::lab
