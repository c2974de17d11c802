// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/session.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>

#include "body/fit/shape_space.h"

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

EngineSettings settings_of(const SessionOptions& options, const hal::SourceInfo& info) {
  EngineSettings settings;
  settings.intrinsics = info.intrinsics;
  settings.width = info.intrinsics.width;
  settings.height = info.intrinsics.height;
  settings.frames_wanted = options.frames;
  settings.frames_min = std::min(settings.frames_min, options.frames);
  settings.calibration_psi = options.calibration == "psi";
  settings.turn = options.turn ? Turn::asked : Turn::none;
  settings.clothed = options.clothed;
  settings.user = options.user;
  settings.live = options.live && info.live;
  settings.single_thread = options.threads == 1;
  return settings;
}

// The synthetic person cannot hear TURN_ROUND, but turns when the front has long been gathered.
constexpr int kTurnSpareFrames = 60;

double now_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

void add_session_options(CLI::App& sub, SessionOptions& options) {
  add_input_options(sub, options.input);
  sub.add_option("--out", options.out, "Folder for result.json, avatar.glb, .obj, .bvh and overlay.png")
      ->type_name("DIR");
  sub.add_option("--tracker", options.tracker, "Tracker file")->type_name("FILE")->capture_default_str();
  sub.add_option("--index", options.index, "Index file")->type_name("FILE")->capture_default_str();
  sub.add_option("--frames", options.frames, "Good frames behind a measurement; with --turn, of each side")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub.add_option("--calibration", options.calibration, "Pose asked for first: none, or psi as in the paper")
      ->check(CLI::IsMember({"none", "psi"}))
      ->capture_default_str();
  sub.add_flag("--turn", options.turn,
               "Front, then back: asks the person to turn round (TURN_ROUND) and measures with both; with the front "
               "alone if the person does not within 15 s or leaves");
  sub.add_flag(
      "--clothed", options.clothed,
      "The person is dressed: measures the body underneath, with wider intervals. Without this, underwear or "
      "close-fitting sportswear is expected");
  sub.add_option("--size-chart", options.size_charts, "Size chart file(s), see docs/result.md (default: EN 13402-3)")
      ->type_name("CSV");
  sub.add_option("--truth", options.input.truth_path, "truth.json of a rendered person, to print errors")
      ->type_name("FILE");
  sub.add_option("--threads", options.threads, "1 or 2; the result does not depend on it")
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
  sub.add_flag("--timing", options.timing, "Add times to the result");
  sub.add_flag("--json", options.json, "Print result.json, and nothing else, on stdout");
}

Result<SessionOutcome> open_session(const SessionOptions& options, FrameWatch engine_watch, FrameTap::Watch watch) {
  auto loaded_tracker = Tracker::load(options.tracker);
  if (!loaded_tracker) return loaded_tracker.error();
  auto tracker = std::make_unique<Tracker>(std::move(*loaded_tracker));
  auto loaded_index = load_index(options.index);
  if (!loaded_index) return loaded_index.error();
  auto index = std::make_unique<index::Index>(std::move(*loaded_index));
  auto model = load_body(options.input.body);
  if (!model) return model.error();
  auto charts = load_charts(options.size_charts);
  if (!charts) return charts.error();
  if (!options.out.empty())
    if (const auto made = make_directory(options.out); !made) return made.error();
  InputOptions opening = options.input;
  opening.turn_after_frames = options.turn ? options.frames + kTurnSpareFrames : 0;
  opening.clothed = options.clothed;
  auto input = open_input(opening);
  if (!input) return input.error();

  EngineSettings settings = settings_of(options, input->source->info());
  settings.watch = std::move(engine_watch);
  settings.shape_space = &model->shape_space();
  if (index->fit_size() == 0 || index->shape_key() != model->shape_space().key)
    fmt::print(stderr,
               "{}: not made with the shapes of {}: features answer alone, less well; build the index again with "
               "im2fit-lab index\n",
               options.index, options.input.body);
  auto engine = Engine::create(settings, tracker->model(), *index);
  if (!engine) return engine.error();
  SessionOutcome outcome{std::move(tracker), std::move(index),   std::move(*model), std::move(*charts),
                         std::move(*input),  std::move(*engine), nullptr,           {},
                         std::nullopt};
  outcome.tap = std::make_unique<FrameTap>(*outcome.input.source, 0, std::move(watch));
  catch_interrupt();
  return outcome;
}

Status conclude(SessionOutcome& outcome) {
  outcome.body.reset();
  ResultReport& report = outcome.report;
  report = {};
  if (auto sound = outcome.engine->fault(); !sound) return sound;
  report.result = outcome.engine->result();
  report.source = outcome.input.source->info();
  if (!report.result.measured) return Ok{};
  const index::Answer& answer = report.result.answer;
  report.size = size_probabilities(outcome.charts, answer.measurements[measurement_index(Measurement::chest_girth)],
                                   answer.female);
  auto body =
      body_of_answer(outcome.body_model, *outcome.index, answer, report.result.measured_joints, report.result.floor);
  if (!body) return body.error();
  outcome.body = std::move(*body);
  report.body = outcome.body->params;
  report.modifier_names = outcome.body_model.modifier_names();
  return Ok{};
}

Result<SessionOutcome> run_session(const SessionOptions& options, const SessionWatch& watch) {
  const Engine* engine = nullptr;
  double answered_ms = 0;
  auto outcome = open_session(options, nullptr, [&](std::uint64_t frame_count) {
    const EngineResult result = engine->result();
    if (result.measured && answered_ms == 0) answered_ms = now_ms();
    if (watch) watch(frame_count, result);
  });
  if (!outcome) return outcome;
  engine = outcome->engine.get();
  const double started_ms = now_ms();
  if (const auto done = run(*outcome->engine, *outcome->tap, true); !done) return done.error();
  // Damaged frames among good ones are left out; nothing but damage is no stream.
  if (outcome->engine->result().frames_seen == 0 && outcome->tap->first_damage())
    return *outcome->tap->first_damage();
  if (const auto concluded = conclude(*outcome); !concluded) return concluded.error();
  if (options.timing)
    outcome->report.timing =
        ResultTiming{now_ms() - started_ms, (answered_ms > 0 ? answered_ms : now_ms()) - started_ms};
  return outcome;
}

}  // namespace im2fit::apps
