// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <csignal>
#include <optional>

#include "apps/common/events.h"
#include "apps/common/input.h"
#include "apps/common/progress.h"
#include "apps/im2fit/commands.h"
#include "apps/im2fit/session.h"
#include "engine/sensing_stages.h"
#include "hal/folder/depth_folder.h"
#include "hal/openni2/oni_writer.h"
#include "hal/recording/zip_folder.h"

namespace im2fit::apps {
namespace {

struct RecordOptions {
  InputOptions input;
  std::string out;
  int frames = 60;
  bool json = false;
  bool convert = false;  // the same of a recording, whole
  std::string motion;    // file of the joints over time; "": none
  std::string tracker = default_tracker_path();
};

bool is_oni(const std::string& path) {
  return path.size() > 4 && path.substr(path.size() - 4) == ".oni";
}

// "12 frames", and the losses: a recording has every frame, or reports the missing ones.
std::string counts(std::uint64_t frames, const hal::SourceStats& stats, std::uint64_t losses) {
  std::string words = fmt::format("{} frames", frames);
  if (stats.gaps > 0) words += fmt::format(", {} missing", stats.gaps);
  if (stats.damaged > 0) words += fmt::format(", {} damaged and left out", stats.damaged);
  if (losses > 0) words += fmt::format(", the camera was lost {} times", losses);
  return words;
}

// Follows the person in view while frames are recorded. Measures nobody.
class Follower {
 public:
  static Result<std::unique_ptr<Follower>> create(const RecordOptions& options, const hal::SourceInfo& source) {
    auto made = std::make_unique<Follower>();
    for (const std::string* path : {&options.tracker, &options.input.body})
      if (auto named = check_named_by_variable(*path); !named) return named.error();
    auto tracker = Tracker::load(options.tracker);
    if (!tracker) return tracker.error();
    made->tracker_ = std::make_unique<Tracker>(std::move(*tracker));
    auto model = load_body(options.input.body);
    if (!model) return model.error();
    made->model_ = std::make_unique<body::BodyModel>(std::move(*model));
    EngineSettings settings;
    settings.intrinsics = source.intrinsics;
    settings.width = source.intrinsics.width;
    settings.height = source.intrinsics.height;
    settings.live = source.live;
    settings.watch = [motion = &made->motion_](const FrameSeen& frame) { motion->see(frame); };
    auto engine = create_engine(
        settings, std::make_unique<SensingStages>(settings.width, settings.height, made->tracker_->model()));
    if (!engine) return engine.error();
    made->engine_ = std::move(*engine);
    return made;
  }
  Status follow(DepthView depth, const hal::FrameInfo& info) { return engine_->push(depth, info); }
  Result<std::string> write(const std::string& path) {
    engine_->finish();
    return write_motion(motion_, path, *model_, std::nullopt);
  }

 private:
  std::unique_ptr<Tracker> tracker_;
  std::unique_ptr<body::BodyModel> model_;
  MotionRecording motion_;
  std::unique_ptr<Engine> engine_;
};

struct Recorded {
  std::uint64_t frames = 0;
  std::string beside;                 // another file that belongs to it; "": none
  std::vector<std::string> not_kept;  // of what the source told, for which the target has no place
};

// What a source's frames told besides depth.
struct Told {
  bool poses = false, gravity = false, two_clocks = false;
  void see(const hal::FrameInfo& info) {
    poses = poses || info.pose;
    gravity = gravity || info.down;
    two_clocks = two_clocks || (info.device_us >= 0 && info.device_us != info.host_ns / 1000);
  }
};

std::vector<std::string> not_kept(const Told& told, bool oni) {
  std::vector<std::string> words;
  if (oni && told.poses) words.emplace_back("poses");
  if (oni && told.gravity) words.emplace_back("gravity");
  if (oni && told.two_clocks) words.emplace_back("host times");
  return words;
}

Status report(const RecordOptions& options, const Recorded& recorded, const hal::SourceStats& stats,
              std::uint64_t losses) {
  if (!options.json) {
    fmt::print("{}: {}{}\n", options.out, counts(recorded.frames, stats, losses),
               recorded.beside.empty() ? "" : ", calibration in " + recorded.beside);
    if (!recorded.not_kept.empty()) fmt::print("not kept: {}\n", fmt::join(recorded.not_kept, ", "));
    return flush_output();
  }
  const Json summary = {{"path", options.out},
                        {"frames", recorded.frames},
                        {"missing", stats.gaps},
                        {"damaged", stats.damaged},
                        {"losses", losses},
                        {"complete", stats.gaps == 0 && stats.damaged == 0 && losses == 0},
                        {"not_kept", recorded.not_kept}};
  fmt::print("{}", line_of(summary));
  return flush_output();
}

Error with_kept(Error error, const std::string& path, std::uint64_t frames) {
  if (frames > 0) error.message += fmt::format("; {} holds the {} frames before", path, frames);
  return error;
}

// Writes each frame, and shows it to `follower`, which may be null.
template <class Writer>
class WriterSink final : public FrameSink {
 public:
  WriterSink(Writer& writer, const Intrinsics& k, Follower* follower)
      : writer_(writer),
        follower_(follower),
        pixels_(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height)),
        depth_(pixels_.data(), k.width, k.height) {}
  Result<DepthImage> acquire() override { return depth_; }
  Status commit(const hal::FrameInfo& info) override {
    if (auto written = writer_.write(depth_, info); !written) return written;
    told_.see(info);
    return follower_ != nullptr ? follower_->follow(depth_, info) : Ok{};
  }
  const Told& told() const { return told_; }

 private:
  Writer& writer_;
  Follower* follower_;
  std::vector<std::uint16_t> pixels_;
  DepthImage depth_;
  Told told_;
};

// `kept` says where the frames are once the writer has finished.
template <class Writer, class Kept>
Result<Recorded> record_with(Writer& writer, FrameTap& tap, Follower* follower, bool oni, const Kept& kept) {
  if (const auto started = tap.start(); !started) return started.error();
  WriterSink<Writer> sink(writer, tap.info().intrinsics, follower);
  const auto pulled = pump_all(tap, sink, [] { return true; });
  tap.stop();
  const auto finished = writer.finish();
  const auto frames = static_cast<std::uint64_t>(writer.frame_count());
  if (!pulled) return with_kept(pulled.error(), kept(), frames);
  if (!finished) return with_kept(finished.error(), kept(), frames);
  return Recorded{frames, "", not_kept(sink.told(), oni)};
}

Result<Recorded> record_oni(FrameTap& tap, Follower* follower, const std::string& path) {
  auto writer = hal::OniWriter::create(path, tap.info().intrinsics, {tap.info().name, tap.info().intrinsics_origin});
  if (!writer) return writer.error();
  auto recorded = record_with(**writer, tap, follower, true, [&] { return (*writer)->kept_path(); });
  if (recorded) recorded->beside = hal::oni_sidecar_path(path);
  return recorded;
}

Result<Recorded> record_folder(FrameTap& tap, Follower* follower, const std::string& path) {
  hal::FolderWriter::Options writing;
  writing.camera_name = tap.info().name;
  writing.origin = tap.info().intrinsics_origin;
  auto writer = hal::FolderWriter::create(path, tap.info().intrinsics, writing);
  if (!writer) return writer.error();
  return record_with(**writer, tap, follower, false, [&] { return path; });
}

// Endings of formats that are not written: a folder of this name would be a riddle.
Status check_target(const std::string& out) {
  for (const char* ending : {".mkv", ".bag", ".r3d", ".zip", ".mp4", ".db3", ".mcap", ".png", ".npy", ".raw"})
    if (out.ends_with(ending))
      return Error{ErrorCode::unsupported,
                   out + ": " + ending + " files are not written; give PATH.oni or the name of a new folder"};
  return Ok{};
}

Result<int> run_record(const RecordOptions& given) {
  RecordOptions options = given;
  std::uint64_t losses = 0;
  options.input.camera_changed = [&](const hal::ReconnectStats& stats, const hal::SourceInfo& source) {
    losses = stats.lost;
    print_error(camera_words(stats, source));
  };
  if (options.convert)
    if (const auto ok = check_target(options.out); !ok) return ok.error();
  auto input = open_input(options.input);
  if (!input) return input.error();
  if (const hal::SourceInfo& info = input->source->info();
      options.convert && (info.live || info.frame_count < 0) && !is_oni(options.input.source))
    return Error{ErrorCode::invalid_argument, options.input.source +
                                                  " is a camera and never ends; record it: im2fit record " +
                                                  options.input.source + " --out " + options.out};
  std::unique_ptr<Follower> follower;
  if (!options.motion.empty()) {
    auto made = Follower::create(options, input->source->info());
    if (!made) return made.error();
    follower = std::move(*made);
  }
  catch_interrupt();
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the size limit is an error of write(), as on a full disk
  const auto frames = static_cast<std::uint64_t>(options.frames);
  std::optional<Progress> progress(std::in_place, "recording", frames);
  FrameTap tap(*input->source, frames, [&](std::uint64_t done) { progress->update(done); });
  auto recorded = is_oni(options.out) ? record_oni(tap, follower.get(), options.out)
                                      : record_folder(tap, follower.get(), options.out);
  progress.reset();  // its line goes before anything else is printed
  if (!recorded) return recorded.error();
  if (const auto* folder = hal::folder_of(*input->source); folder != nullptr && folder->uses_confidence())
    recorded->not_kept.emplace_back("confidence (unsure pixels have no depth)");
  if (input->truth) {
    const std::string path = is_oni(options.out) ? options.out.substr(0, options.out.size() - 4) + ".truth.json"
                                                 : options.out + "/truth.json";
    if (const auto written = write_truth(*input->truth, path); !written) return written.error();
  }
  if (auto reported = report(options, *recorded, tap.stats(), losses); !reported) return reported.error();
  if (follower != nullptr) {
    const auto moved = follower->write(options.motion);
    if (!moved) return moved.error();
    if (!options.json) fmt::print("{}", *moved);
  }
  return kExitOk;
}

}  // namespace

void add_convert(cli::App& app, Command& chosen) {
  auto options = std::make_shared<RecordOptions>();
  options->convert = true;
  options->frames = 0;
  auto* sub = add_command<RecordOptions>(
      app, chosen, "convert", "Convert a recording to a depth folder or an OpenNI2 .oni file",
      "  im2fit convert c00a170fe1 person\n  im2fit convert person.oni person --json", options, run_record);
  add_input_options(*sub, options->input);
  sub->add_option("OUT", options->out, "PATH.oni, which OpenNI2 programs can read too, or a new folder")->required();
  sub->add_flag(
      "--json", options->json,
      "Print the numbers of written, missing and damaged frames, and the data that OUT cannot store, as one line "
      "of JSON");
}

void add_record(cli::App& app, Command& chosen) {
  auto options = std::make_shared<RecordOptions>();
  auto* sub = add_command<RecordOptions>(
      app, chosen, "record", "Record a source to an OpenNI2 .oni file or a depth folder",
      "  im2fit record openni2 --out person.oni --frames 90\n  im2fit record synthetic:7 --out person7", options,
      run_record);
  add_input_options(*sub, options->input);
  options->input.reconnect_s = 10;
  add_reconnect_option(*sub, options->input);
  sub->add_flag("--json", options->json,
                "Print the numbers of recorded, missing and damaged frames as one line of JSON");
  sub->add_option("--out", options->out, "PATH.oni, which OpenNI2 programs can read too, or a new folder")
      ->required()
      ->type_name("PATH");
  add_motion_option(*sub, options->motion);
  sub->add_option("--tracker", options->tracker, "Tracker file, for --motion")
      ->type_name("FILE")
      ->capture_default_str();
  sub->add_option("--frames", options->frames, "Frames to record; 0: until the source ends or Ctrl-C")
      ->range(0, 1'000'000'000)
      ->capture_default_str();
}

}  // namespace im2fit::apps
