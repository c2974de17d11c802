// SPDX-License-Identifier: Apache-2.0
#include "apps/common/measuring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "body/fit/shape_space.h"
#include "engine/report/dressing.h"
#include "engine/report/tape_file.h"

namespace im2fit::apps {
namespace {

Result<SizeSystem> load_charts(const std::vector<std::string>& paths) {
  if (paths.empty()) return builtin_size_system();
  std::vector<SizeChart> charts;
  for (const std::string& path : paths) {
    auto chart = load_size_chart(path);
    if (!chart) return chart.error();
    charts.push_back(std::move(*chart));
  }
  return make_size_system(std::move(charts));
}

// None: auto.
std::optional<SensorKind> named_sensor(const std::string& name) {
  for (const SensorKind kind : {SensorKind::structured_light, SensorKind::time_of_flight})
    if (name == name_of(kind)) return kind;
  return std::nullopt;
}

}  // namespace

Result<MeasuringData> load_measuring_data(const MeasuringOptions& options, const std::string& body) {
  auto loaded_tracker = Tracker::load(options.tracker);
  if (!loaded_tracker) return loaded_tracker.error();
  auto tracker = std::make_unique<Tracker>(std::move(*loaded_tracker));
  auto loaded_index = load_index(options.index);
  if (!loaded_index) return loaded_index.error();
  auto index = std::make_unique<index::Index>(std::move(*loaded_index));
  auto model = load_body(body);
  if (!model) return model.error();
  auto charts = load_charts(options.size_charts);
  if (!charts) return charts.error();
  auto tape = load_tapes(options.tapes);
  if (!tape) return tape.error();
  std::string warning;
  if (index->fit_layout().size() == 0 || index->shape_key() != model->shape_space().key)
    warning = fmt::format(
        "{}: not made with the shapes of {}: features answer alone, less well; build the index again with "
        "im2fit-lab index",
        options.index, body);
  return MeasuringData{std::move(tracker),
                       std::move(index),
                       std::move(*model),
                       std::move(*charts),
                       std::make_unique<body::Tape>(std::move(*tape)),
                       std::move(warning)};
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
  settings.turn = options.turn ? Turn::asked : Turn::none;
  settings.clothing = clothing_of(options.clothing);
  settings.sensor = named_sensor(options.sensor).value_or(source.sensor);
  settings.user = options.user;
  settings.live = options.live && source.live;
  settings.single_thread = options.threads == 1;
  settings.watch = std::move(watch);
  settings.shape_space = &data.body_model.shape_space();
  auto engine = Engine::create(settings, data.tracker->model(), *data.index);
  if (!engine)
    return Error{engine.error().code,
                 fmt::format("{} with {}: {}", options.index, options.tracker, engine.error().message)};
  return engine;
}

Result<Answered> answer_of(const Engine& engine, const MeasuringData& data, const hal::SourceInfo& source) {
  if (auto sound = engine.fault(); !sound) return sound.error();
  Answered answered;
  ResultReport& report = answered.report;
  report.result = engine.result();
  report.source = source;
  if (!report.result.measured) return answered;
  const index::Answer& answer = report.result.answer;
  report.size = size_probabilities(data.charts, answer.measurements[measurement_index(Measurement::chest_girth)],
                                   answer.female);
  auto body =
      body_of_answer(data.body_model, *data.index, answer, report.result.measured_joints, report.result.floor);
  if (!body) return body.error();
  answered.body = std::move(*body);
  report.body = answered.body->params;
  report.body_fit = answered.body->fit;
  report.modifier_names = data.body_model.modifier_names();
  report.tape = data.tape.get();
  report.tape_values.resize(data.tape->definitions.size());
  body::TapeMeasurer(data.body_model).measure(*data.tape, answered.body->params, report.tape_values);
  report.tape_intervals = tape_intervals(*data.tape, report.tape_values, answer);
  report.fits =
      fits_of(builtin_wardrobe(), data.charts, answer.female, *data.tape, report.tape_values, report.tape_intervals);
  return answered;
}

// LOST is left at once by whoever is found, as long as another beginning is allowed.
bool is_stuck(const EngineResult& result) {
  return result.state == SessionState::lost && result.user != 0;
}

std::string summary(const ResultReport& report) {
  const auto& values = report.result.answer.measurements;
  std::string words =
      fmt::format("{:.0f} mm, {:.1f} kg, chest {:.0f} mm", values[measurement_index(Measurement::stature)].value,
                  values[measurement_index(Measurement::weight)].value,
                  values[measurement_index(Measurement::chest_girth)].value);
  if (report.size) words += ", size " + report.size->best;
  return words;
}

std::string body_note(const ResultReport& report) {
  const MeasurementValues& residual = report.body_fit.residual;
  if (!report.body || body::girth_residual_mm(residual) <= body::kResidualToldMm) return "";
  std::string off;
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    if (kMeasurementTable[i].unit == "mm" && std::abs(residual[i]) > body::kResidualToldMm)
      off += fmt::format("{}{} {:+.0f} mm", off.empty() ? "" : ", ", kMeasurementTable[i].id, residual[i]);
  return "no body measures all that is reported; the avatar is off by " + off;
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
