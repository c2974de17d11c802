// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "apps/common/input.h"
#include "apps/im2fit/commands.h"
#include "hal/folder/depth_folder.h"
#include "hal/open/open.h"

namespace im2fit::apps {
namespace {

struct RecordOptions {
  InputOptions input;
  std::string out;
  int frames = 60;
};

constexpr int kWaitMs = 250;
constexpr int kPatienceMs = 5000;

bool is_oni(const std::string& path) {
  return path.size() > 4 && path.substr(path.size() - 4) == ".oni";
}

// Hands every frame to `take` until the source ends, the tap closes or `take` fails.
Status pull(hal::Source& source, const std::function<Status(DepthView, const hal::FrameInfo&)>& take) {
  const Intrinsics& k = source.info().intrinsics;
  std::vector<std::uint16_t> pixels(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  const DepthImage depth(pixels.data(), k.width, k.height);
  for (int silent_ms = 0;;) {
    const auto frame = source.next(depth, kWaitMs);
    if (frame) {
      silent_ms = 0;
      if (auto taken = take(depth, *frame); !taken) return taken;
      continue;
    }
    if (frame.error().code == ErrorCode::end_of_stream) return Ok{};
    if (frame.error().code == ErrorCode::corrupt) continue;
    if (frame.error().code != ErrorCode::timeout) return frame.error();
    silent_ms += kWaitMs;
    if (silent_ms >= kPatienceMs)
      return Error{ErrorCode::timeout, fmt::format("{}: no frame for {} s; is the camera still connected?",
                                                   source.info().uri, kPatienceMs / 1000)};
  }
}

Result<int> record_oni(hal::Source& camera, FrameTap& tap, const std::string& path) {
  if (const auto begun = hal::begin_oni_recording(camera, path); !begun) return begun.error();
  if (const auto started = tap.start(); !started) return started.error();
  const auto pulled = pull(tap, [](DepthView, const hal::FrameInfo&) -> Status { return Ok{}; });
  const auto recording = hal::end_oni_recording(camera);
  tap.stop();
  if (!pulled) return pulled.error();
  if (!recording) return recording.error();
  fmt::print("{}: {} frames, calibration in {}\n", recording->path, recording->frames_seen,
             recording->camera_yaml_path);
  return kExitOk;
}

Result<int> record_folder(FrameTap& tap, const std::string& path) {
  hal::FolderWriter::Options writing;
  writing.camera_name = tap.info().name;
  writing.origin = tap.info().intrinsics_origin;
  auto writer = hal::FolderWriter::create(path, tap.info().intrinsics, writing);
  if (!writer) return writer.error();
  if (const auto started = tap.start(); !started) return started.error();
  const auto pulled =
      pull(tap, [&](DepthView depth, const hal::FrameInfo& info) { return (*writer)->write(depth, info); });
  tap.stop();
  const auto finished = (*writer)->finish();
  if (!pulled) return pulled.error();
  if (!finished) return finished.error();
  fmt::print("{}: {} frames\n", path, (*writer)->frame_count());
  return kExitOk;
}

Result<int> run_record(const RecordOptions& options) {
  auto input = open_input(options.input);
  if (!input) return input.error();
  catch_interrupt();
  const auto frames = static_cast<std::uint64_t>(options.frames);
  Progress progress("recording", frames);
  FrameTap tap(*input->source, frames, [&](std::uint64_t done) { progress.update(done); });
  auto code = is_oni(options.out) ? record_oni(*input->source, tap, options.out) : record_folder(tap, options.out);
  if (code && input->truth) {
    const std::string path = is_oni(options.out) ? options.out.substr(0, options.out.size() - 4) + ".truth.json"
                                                 : options.out + "/truth.json";
    if (const auto written = write_truth(*input->truth, path); !written) return written.error();
  }
  return code;
}

}  // namespace

void add_record(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<RecordOptions>();
  auto* sub = add_command<RecordOptions>(
      app, chosen, "record", "Record a source to an OpenNI2 .oni file or a depth folder",
      "  im2fit record openni2 --out person.oni --frames 90\n  im2fit record synthetic:7 --out person7", options,
      run_record);
  add_input_options(*sub, options->input);
  sub->add_option("--out", options->out, "PATH.oni (OpenNI2 cameras) or a folder to make")
      ->required()
      ->type_name("PATH");
  sub->add_option("--frames", options->frames, "Frames; 0: until the source ends or Ctrl-C")
      ->check(CLI::Range(0, 1'000'000'000))
      ->capture_default_str();
}

}  // namespace im2fit::apps
