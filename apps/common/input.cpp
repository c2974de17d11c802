// SPDX-License-Identifier: Apache-2.0
#include "apps/common/input.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "apps/common/events.h"
#include "hal/open/open.h"
#if IM2FIT_HAVE_LAB
#include "train/camera/synthetic_person.h"
#endif

namespace im2fit::apps {
namespace {

constexpr auto kHoldPeriod = std::chrono::milliseconds(20);

std::atomic<bool> interrupt_seen{false};

std::string truth_beside(const std::string& uri) {
  const std::filesystem::path source(uri);
  if (std::error_code code; std::filesystem::is_regular_file(source, code))
    return std::filesystem::path(source).replace_extension(".truth.json").string();
  return (source / "truth.json").string();
}

// A requested truth file must be valid. One beside the source only adds to the output: an invalid one there does not
// stop the program.
Result<std::optional<Truth>> find_truth(const InputOptions& options) {
  if (!options.truth_path.empty()) {
    auto truth = read_truth(options.truth_path);
    if (!truth) return truth.error();
    return std::optional<Truth>(std::move(*truth));
  }
  std::error_code code;
  const std::string beside = truth_beside(options.source);
  if (!std::filesystem::exists(beside, code)) return std::optional<Truth>();
  auto truth = read_truth(beside);
  if (truth) return std::optional<Truth>(std::move(*truth));
  print_error(truth.error().message + "; continuing without it");
  return std::optional<Truth>();
}

Result<std::unique_ptr<hal::Source>> open_patiently(const InputOptions& options, const hal::OpenOptions& opening) {
  if (options.reconnect_s == 0) return hal::open_source(options.source, opening);
  hal::ReconnectOptions reconnect;
  reconnect.give_up_ms = options.reconnect_s < 0 ? -1 : 1000 * options.reconnect_s;
  auto about = std::make_shared<hal::SourceInfo>();
  reconnect.changed = [about, notify = options.camera_changed](const hal::ReconnectStats& stats) {
    if (notify)
      notify(stats, *about);
    else if (stats.presence != hal::Presence::given_up)  // that is an error of its own
      print_error(camera_words(stats, *about));
  };
  auto source = hal::open_reconnecting(options.source, opening, reconnect);
  if (source) *about = (*source)->info();
  return source;
}

}  // namespace

void add_input_options(cli::App& sub, InputOptions& options) {
  sub.add_option("SOURCE", options.source,
                 "openni2[:URI] | usb[:SERIAL] | v4l2:/dev/videoN | synthetic[:SEED] | PATH.oni, .mkv, .bag, .zip | "
                 "DEPTH_FOLDER | STRAY_SCANNER_FOLDER | SCANNER_APP_FOLDER | TUM_FOLDER | SCAN.ply, .obj, .glb, .pcd")
      ->required();
  sub.add_option("--rotate", options.rotate_deg, "Mounting of the camera, degrees (default: as recorded)")
      ->one_of({0, 90, 180, 270});
  sub.add_option(
         "--camera", options.camera_yaml,
         "Calibration file that replaces the source's own: from ROS, OpenCV, a camera maker or a phone's recorder")
      ->type_name("FILE");
  sub.add_option("--unit", options.unit_mm,
                 "Unit of a folder's pixels or a scan's lengths in millimetres (0.1; 10: centimetres; 1000: metres). "
                 "Default: 1; for a TUM folder 0.2; for a scan: estimated from the height")
      ->range(0.001, 1000.0);
  sub.add_option(
         "--up", options.scan_up,
         "Axis of a scan that points up: x, -x, y, -y, z, -z. Default: estimated from the longest side and the feet")
      ->one_of({"x", "-x", "y", "-y", "z", "-z"});
  sub.add_option("--body", options.body, "Body file")->type_name("FILE")->capture_default_str();
}

void add_reconnect_option(cli::App& sub, InputOptions& options) {
  sub.add_option("--reconnect", options.reconnect_s,
                 "Seconds to wait for a camera that was unplugged; 0: end with an error, -1: no limit")
      ->range(-1, 2'000'000)
      ->capture_default_str();
}

Result<Input> open_input(const InputOptions& options) {
  Input input;
  hal::OpenOptions opening;
  if (options.rotate_deg >= 0) opening.rotate_deg = options.rotate_deg;
  opening.camera_yaml_path = options.camera_yaml;
  opening.unit_mm = options.unit_mm;
  opening.scan_up = options.scan_up;
#if IM2FIT_HAVE_LAB
  opening.synthetic = [&](const std::string& seed,
                          const hal::OpenOptions& o) -> Result<std::unique_ptr<hal::Source>> {
    if (auto named = check_named_by_variable(options.body); !named) return named.error();
    lab::SyntheticActing acting;
    if (options.turn == Turn::back) acting.turn = lab::turn_after(options.turn_after_frames);
    if (options.turn == Turn::around) acting.step_round = lab::step_round_after(options.turn_after_frames);
    if (options.turn == Turn::walk) acting.step_round = lab::walk_round_after(options.turn_after_frames);
    acting.clothed = options.clothed;
    auto synthetic = lab::open_synthetic(seed, options.body, o.rotate_deg.value_or(90), o.width, o.height, acting);
    if (!synthetic) return synthetic.error();
    input.truth = synthetic->truth;
    return std::move(synthetic->source);
  };
#endif
  auto source = open_patiently(options, opening);
  if (!source) return source.error();
  input.source = std::move(*source);
  if (input.truth && options.truth_path.empty()) return input;  // of the synthetic person
  auto truth = find_truth(options);
  if (!truth) return truth.error();
  input.truth = *truth;
  return input;
}

void catch_interrupt() {
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { interrupt_seen = true; });
}
bool interrupted() {
  return interrupt_seen;
}

FrameTap::FrameTap(hal::Source& source, std::uint64_t frame_count_max, Watch watch)
    : source_(source), frame_count_max_(frame_count_max), watch_(std::move(watch)) {}

std::optional<Error> FrameTap::wait_while_held(DepthImage depth, int timeout_ms) {
  while (held_ && held_()) {
    if (interrupted()) break;
    if (!source_.info().live) {
      std::this_thread::sleep_for(kHoldPeriod);
      continue;
    }
    const auto frame = source_.next(depth, timeout_ms);
    if (frame || frame.error().code == ErrorCode::timeout || frame.error().code == ErrorCode::corrupt) continue;
    return frame.error();
  }
  return std::nullopt;
}

Result<hal::FrameInfo> FrameTap::next(DepthImage depth, int timeout_ms) {
  if (auto gone = wait_while_held(depth, timeout_ms)) return *gone;
  if (interrupted()) return Error{ErrorCode::end_of_stream, "stopped by the user"};
  if (frame_count_max_ > 0 && frame_count_ >= frame_count_max_)
    return Error{ErrorCode::end_of_stream, "the requested number of frames is reached"};
  auto frame = source_.next(depth, timeout_ms);
  if (!frame) {
    if (frame.error().code == ErrorCode::corrupt && !first_damage_) first_damage_ = frame.error();
    return frame;
  }
  ++frame_count_;
  if (watch_) watch_(frame_count_);
  return frame;
}

}  // namespace im2fit::apps
