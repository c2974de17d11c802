// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/session.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <utility>

#include "engine/diagnosis.h"
#include "engine/engine.h"
#include "report/measurement_file.h"
#include "report/result_json.h"
#include "report/vrm_avatar.h"

namespace im2fit::apps {
namespace {

// The synthetic person cannot hear TURN_ROUND, but turns when the front has long been accumulated.
constexpr int kTurnSpareFrames = 60;

double now_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Result<WantedFiles> wanted_files(const std::string& words) {
  constexpr std::pair<std::string_view, bool WantedFiles::*> kWords[] = {
      {"result", &WantedFiles::result},   {"avatar", &WantedFiles::avatar}, {"overlay", &WantedFiles::overlay},
      {"clothes", &WantedFiles::clothes}, {"obj", &WantedFiles::obj},       {"bvh", &WantedFiles::bvh}};
  WantedFiles wanted{false, false, false, false, false, false};
  for (std::size_t begin = 0; begin <= words.size();) {
    const std::size_t end = std::min(words.find(',', begin), words.size());
    const std::string word = words.substr(begin, end - begin);
    const auto* known =
        std::find_if(std::begin(kWords), std::end(kWords), [&](const auto& one) { return one.first == word; });
    if (known == std::end(kWords)) {
      std::string all;
      for (const auto& one : kWords) all += (all.empty() ? "" : ", ") + std::string(one.first);
      return Error{ErrorCode::invalid_argument,
                   (word.empty() ? "an empty word" : "'" + word + "' is not known") + "; words are " + all};
    }
    wanted.*known->second = true;
    begin = end + 1;
  }
  return wanted;
}

WantedFiles wanted_files(const SessionOptions& options) {
  const auto wanted = wanted_files(options.only);
  return wanted ? *wanted : WantedFiles();  // without --only there are no words, and all files are made
}

void add_models_option(cli::App& sub, std::string& tracker, std::string& index, std::string& body) {
  sub.add_option_function(
         "--models",
         [&](const std::string& models) {
           tracker = path_among(models, kTrackerFile);
           index = path_among(models, kIndexFile);
           body = path_among(models, kBodyFile);
         },
         "Model pack (.i2p) or directory with tracker, index and body (default: IM2FIT_MODELS, else the installed "
         "models)")
      ->type_name("PACK|DIR")
      ->check([](const std::string& models) {
        std::error_code code;
        if (std::filesystem::is_directory(models, code) || is_model_pack(models)) return std::string();
        return std::filesystem::exists(models, code)
                   ? models + " is neither a directory nor a model pack; expected a file im2fit-models-VERSION.i2p"
                   : models + " does not exist";
      });
}

void add_session_options(cli::App& sub, SessionOptions& options) {
  add_models_option(sub, options.tracker, options.index, options.input.body);
  add_input_options(sub, options.input);
  add_reconnect_option(sub, options.input);
  sub.add_option("--out", options.out, "Folder for result.json, avatar.glb, .obj, .bvh and overlay.png")
      ->type_name("DIR");
  sub.add_option("--only", options.only,
                 "Comma-separated list of the files of --out; other files are not computed: result, avatar, overlay, "
                 "clothes (on the avatar), obj, bvh. Default: all")
      ->type_name("WORDS")
      ->check([](const std::string& words) {
        const auto wanted = wanted_files(words);
        return wanted ? std::string() : wanted.error().message;
      })
      ->needs(sub.get_option("--out"));
  sub.add_option("--tracker", options.tracker, "Tracker file")->type_name("FILE")->capture_default_str();
  sub.add_option("--index", options.index, "Index file")->type_name("FILE")->capture_default_str();
  sub.add_option("--frames", options.frames,
                 "Accepted frames needed for a measurement; with --turn, for each side; with --around, for the front")
      ->range(1, 1000)
      ->capture_default_str();
  sub.add_option("--calibration", options.calibration,
                 "Pose that the person takes first: none, or psi as in the paper")
      ->one_of({"none", "psi"})
      ->capture_default_str();
  auto* turn = sub.add_word_flag(
      "--turn", options.turn, "back",
      "Measure front and back. Guidance TURN_ROUND asks the person to turn. If the person does not turn within 15 s, "
      "or leaves, only the front is used");
  sub.add_choice_flag(
         "--around", options.turn, {{"person", "around"}, {"camera", "walk"}},
         "Measure from all sides, for a better stature, waist, hip and weight. After the front, the person "
         "turns once on the spot, slowly, in 6 to 15 s, with the arms away from the body. --around=camera: the "
         "person stands still, and the camera is carried round the person in 10 to 30 s; the source must provide "
         "camera poses. Half a turn is sufficient; with less, only the front is used")
      ->excludes(turn);
  sub.add_option("--clothing", options.clothing,
                 "Clothing of the person. bare: underwear or close-fitting sportswear. dressed: the body under the "
                 "clothes is measured, with wider intervals. auto: as bare, and intervals "
                 "widen if the frames show clothes")
      ->one_of(std::vector<std::string>(kClothingGivenNames.begin(), kClothingGivenNames.end()))
      ->capture_default_str();
  add_known_options(sub, options.known_words);
  sub.add_option("--sensor", options.sensor,
                 "Kind of depth sensor, which affects the outline of a person. auto: as reported by the driver, or "
                 "estimated from the noise and from the missing depth beside the person")
      ->one_of(std::vector<std::string>(kSensorKindNames.begin(), kSensorKindNames.end()))
      ->capture_default_str();
  sub.add_option("--user", options.user_word,
                 "Person to measure: nearest, or an id. With an id, other people are ignored")
      ->type_name("nearest|ID")
      ->check([](const std::string& word) {
        return user_of(word) ? std::string() : "expected nearest, or the id that im2fit live shows with a person";
      })
      ->capture_default_str();
  sub.add_option("--region", options.region,
                 "Measure only people whose feet are within this rectangle on the floor, in metres from the point "
                 "under the camera: x to the camera's right, z away from it. -0.6,1.5,0.6,3 is 1.2 m wide")
      ->type_name("X0,Z0,X1,Z1")
      ->check(region_fault);
  sub.add_option("--size-chart", options.size_charts, "Size chart file(s), see docs/result.md (default: EN 13402-3)")
      ->type_name("CSV");
  sub.add_option(
         "--calibration-site", options.site,
         "Site calibration, made by im2fit-lab calibrate; it corrects every value and is named in result.json")
      ->type_name("FILE");
  sub.add_option("--tape", options.tapes,
                 "Your own measurement definitions, see docs/tape.md; their values are in tape of result.json")
      ->type_name("YAML");
  sub.add_option("--truth", options.input.truth_path, "truth.json of a rendered person; the errors are printed")
      ->type_name("FILE");
  sub.add_option("--threads", options.threads, "1 or 2; the result does not depend on it")
      ->one_of({1, 2})
      ->capture_default_str();
  add_motion_option(sub, options.motion);
  sub.add_option("--export", options.exports,
                 "File(s) for all measurements: .smis (Seamly2D), .json (FreeSewing), .yaml (GarmentCode), .csv; or "
                 ".vrm, the avatar for VRM 1.0; see docs/tape.md")
      ->type_name("FILE")
      ->check([](const std::string& path) {
        if (is_vrm_name(path)) return std::string();
        const std::string fault = measurement_file_fault(path);
        return fault.empty() ? fault : fault + ", or .vrm (the avatar)";
      });
  sub.add_option("--export-unit", options.export_unit,
                 "Unit of .csv; in also applies to .smis, which otherwise uses cm")
      ->one_of({"mm", "cm", "in"})
      ->capture_default_str();
  sub.add_flag("--paper", options.paper, "Add the values of the paper's estimators to the table");
  sub.add_flag("--timing", options.timing, "Add processing times to the result");
  sub.add_flag("--json", options.json, "Print only result.json on stdout");
}

void add_motion_option(cli::App& sub, std::string& path) {
  sub.add_option("--motion", path, "File for the joints over time: .csv, .bvh or .glb, see docs/motion.md")
      ->type_name("FILE")
      ->check(MotionRecording::fault_of);
}

void ShownFrame::see(const FrameSeen& frame) {
  const EngineResult& result = frame.result;
  if (result.session != session_) used_ = 0;
  session_ = result.session;
  const std::uint64_t used = result.frames_used - result.frames_back;
  if (used == used_ && used_ > 0) return;
  used_ = used;
  width_ = frame.depth.width;
  height_ = frame.depth.height;
  pixels_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int v = 0; v < height_; ++v)
    std::copy_n(frame.depth.row(v), width_, pixels_.data() + static_cast<std::ptrdiff_t>(v) * width_);
}

DepthView ShownFrame::depth() const {
  return pixels_.empty() ? DepthView() : DepthView(pixels_.data(), width_, height_);
}

Result<SessionOutcome> open_session(const SessionOptions& options, FrameWatch engine_watch, FrameTap::Watch watch) {
  // What is cheap to check comes before what takes long: the models' absence, the source, the folder, the models.
  if (auto there = check_models(options, options.input.body); !there) return there.error();
  InputOptions opening = options.input;
  opening.turn = turn_of(options.turn);
  opening.turn_after_frames = options.frames + kTurnSpareFrames;
  opening.clothed = clothing_of(options.clothing) == ClothingGiven::dressed;
  auto input = open_input(opening);
  if (!input) return input.error();
  if (!options.out.empty())
    if (const auto made = make_directory(options.out); !made) return made.error();
  auto data = load_measuring_data(options, options.input.body);
  if (!data) return data.error();
  // Of what is printed or written, result.json, clothes, exports and a chart of one's own alone rest on the tape.
  const WantedFiles wanted = wanted_files(options);
  if (!options.live && !options.json && options.exports.empty() && options.size_charts.empty() &&
      (options.out.empty() || !(wanted.result || wanted.clothes)))
    data->tape.reset();
  for (const std::string& warning : data->warnings) fmt::print(stderr, "{}\n", warning);
  auto shown = std::make_unique<ShownFrame>();
  std::unique_ptr<MotionRecording> motion;
  if (!options.motion.empty()) motion = std::make_unique<MotionRecording>();
  const auto watch_all = [shown_frame = shown.get(), recording = motion.get(),
                          others = std::move(engine_watch)](const FrameSeen& frame) {
    shown_frame->see(frame);
    if (recording != nullptr) recording->see(frame);
    if (others) others(frame);
  };
  MeasuringOptions measuring = options;
  measuring.known = known_facts(options.known_words);
  measuring.user = user_of(options.user_word).value_or(0);
  auto engine = make_engine(measuring, *data, input->source->info(), watch_all);
  if (!engine) return engine.error();
  SessionOutcome outcome;
  outcome.data = std::move(*data);
  outcome.input = std::move(*input);
  outcome.motion = std::move(motion);
  outcome.shown = std::move(shown);
  outcome.engine = std::move(*engine);
  outcome.tap = std::make_unique<FrameTap>(*outcome.input.source, 0, std::move(watch));
  catch_interrupt();
  return outcome;
}

namespace {

// `frames_damaged`: of the frames behind the person.
Status take_person(SessionOutcome& outcome, Result<PersonMeasurement> person, std::uint64_t frames_damaged) {
  outcome.avatar.reset();
  outcome.person = {};
  if (!person) return person.error();
  outcome.person = std::move(*person);
  outcome.person.frames_damaged = frames_damaged;
  return Ok{};
}

}  // namespace

Status conclude(SessionOutcome& outcome) {
  const hal::Source& source = *outcome.input.source;
  const auto taken =
      take_person(outcome, measured_person(*outcome.engine, outcome.data, source.info()), source.stats().damaged);
  if (!taken) return taken;
  if (!outcome.person.result.measured && has(reported_guidance(outcome.person), Guidance::no_person))
    outcome.person.diagnosis =
        hal::read_in_unit(diagnose(outcome.shown->depth(), source.info().intrinsics, &outcome.data.tracker->model()),
                          source.info().unit_mm);
  return Ok{};
}

Status conclude_again(SessionOutcome& outcome, const EngineResult& unconditioned, const KnownFacts& facts) {
  auto person = measured_person(with_known(unconditioned, facts), outcome.data, outcome.input.source->info());
  return take_person(outcome, std::move(person), outcome.person.frames_damaged);
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
  // Damaged frames among good ones are left out. If all frames are damaged there is no stream.
  if (outcome->engine->result().frames_seen == 0 && outcome->tap->first_damage())
    return *outcome->tap->first_damage();
  if (const auto concluded = conclude(*outcome); !concluded) return concluded.error();
  if (options.timing)
    outcome->timing = ResultTiming{now_ms() - started_ms, (answered_ms > 0 ? answered_ms : now_ms()) - started_ms};
  return outcome;
}

}  // namespace im2fit::apps
