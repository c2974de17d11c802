// SPDX-License-Identifier: Apache-2.0
#include "apps/common/measuring.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "person/data_files.h"
#include "person/dressing.h"
#include "person/tape_file.h"

namespace im2fit::apps {
namespace {

// None: auto.
std::optional<SensorKind> named_sensor(const std::string& name) {
  for (const SensorKind kind : {SensorKind::structured_light, SensorKind::time_of_flight, SensorKind::stereo})
    if (name == name_of(kind)) return kind;
  return std::nullopt;
}

}  // namespace

std::optional<int> user_of(const std::string& word) {
  if (word == "nearest") return 0;
  int id = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, id);
  if (error != std::errc() || stop != end || id < 1) return std::nullopt;
  return id;
}

Status check_models(const MeasuringOptions& options, const std::string& body) {
  for (const std::string* path : {&options.tracker, &options.index, &body})
    if (auto named = check_named_by_variable(*path); !named) return named;
  return check_data_files(options.tracker, options.index, body);
}

Result<MeasuringData> load_measuring_data(const MeasuringOptions& options, const std::string& body) {
  if (auto there = check_models(options, body); !there) return there.error();
  auto tape = load_tapes(options.tapes);
  if (!tape) return tape.error();
  auto data = im2fit::load_measuring_data({options.tracker, options.index, body, options.size_charts, options.site});
  if (!data) return data;
  data->tape = std::make_unique<body::Tape>(std::move(*tape));
  return data;
}

Result<std::unique_ptr<Engine>> make_engine(const MeasuringOptions& options, const MeasuringData& data,
                                            const hal::SourceInfo& source, FrameWatch watch) {
  EngineSettings settings;
  settings.intrinsics = source.intrinsics;
  settings.width = source.intrinsics.width;
  settings.height = source.intrinsics.height;
  settings.frames_wanted = options.frames;
  settings.frames_min = std::min(settings.frames_min, options.frames);
  settings.calibration_psi = options.calibration == "psi";
  settings.turn = turn_of(options.turn);
  settings.clothing = clothing_of(options.clothing);
  settings.sensor = named_sensor(options.sensor).value_or(source.sensor);
  settings.user = options.user;
  settings.region = region_of(options.region);
  settings.live = options.live && source.live;
  settings.single_thread = options.threads == 1;
  settings.one_after_another = options.one_after_another;
  settings.rest = options.rest && source.live;
  settings.watch = std::move(watch);
  auto engine = im2fit::make_engine(std::move(settings), data, source.name);
  if (engine)
    if (auto ok = (*engine)->set_known(options.known, 0); !ok) return ok.error();
  return engine;
}

Result<PersonMeasurement> measured_person(const Engine& engine, const MeasuringData& data,
                                          const hal::SourceInfo& source) {
  if (auto sound = engine.fault(); !sound) return sound.error();
  return measured_person(engine.result(), data, source);
}

Result<PersonMeasurement> measured_person(const EngineResult& result, const MeasuringData& data,
                                          const hal::SourceInfo& source) {
  auto person = measurement_of(result, data.parts(), source);
  if (person && person->body && person->tape != nullptr)
    person->fits = fits_of(builtin_wardrobe(), *data.charts, person->result.answer.female, *person->tape,
                           person->tape_values, person->tape_intervals);
  return person;
}

// The session leaves LOST as soon as it finds a person, as long as another beginning is allowed.
bool is_stuck(const EngineResult& result) {
  return result.state == SessionState::lost && result.user != 0;
}

std::string summary(const PersonMeasurement& person) {
  const auto& values = person.result.answer.measurements;
  std::string words =
      fmt::format("{:.0f} mm, {:.1f} kg, chest {:.0f} mm", values[measurement_index(Measurement::stature)].value,
                  values[measurement_index(Measurement::weight)].value,
                  values[measurement_index(Measurement::chest_girth)].value);
  if (person.size) words += ", size " + person.size->best;
  return words;
}

std::string body_note(const PersonMeasurement& person) {
  if (!person.body) return "";
  const MeasurementValues& residual = person.body->fit.residual;
  if (body::girth_residual_mm(residual) <= body::kResidualToldMm) return "";
  std::string off;
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    if (kMeasurementTable[i].unit == "mm" && std::abs(residual[i]) > body::kResidualToldMm)
      off += fmt::format("{}{} {:+.0f} mm", off.empty() ? "" : ", ", kMeasurementTable[i].id, residual[i]);
  return "no body has all of the reported values; the avatar differs by " + off;
}

std::string guidance_words(GuidanceSet guidance, ArmSet arms_close) {
  if (guidance == 0) return "none";
  std::string words;
  for (std::size_t i = 0; i < kGuidanceCount; ++i) {
    const GuidanceSet code = guidance & 1U << i;
    if (code == 0) continue;
    if (!words.empty()) words += ", ";
    words += kGuidanceNames[i];
    const auto arms = names_of_arms(arms_close);
    if (has(code, Guidance::arms_close) && arms.size() == 1) words.append(" ").append(arms.front());
  }
  return words;
}

}  // namespace im2fit::apps
