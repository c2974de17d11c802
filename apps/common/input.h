// SPDX-License-Identifier: Apache-2.0
// SOURCE and its options, the same for every command that reads one.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/paths.h"
#include "apps/common/program.h"
#include "engine/engine.h"
#include "formats/truth_file.h"
#include "hal/reconnecting_source.h"
#include "hal/source.h"

namespace im2fit::apps {

struct InputOptions {
  std::string source;
  int rotate_deg = -1;  // -1: as the recording specifies
  std::string camera_yaml;
  double unit_mm = 0;                      // of a folder's pixels; 0: as it has them
  std::string scan_up;                     // of a scan; "": found
  std::string body = default_body_path();  // of the synthetic person, too
  Turn turn = Turn::none;                  // of the synthetic person, who stands for so many frames first
  int turn_after_frames = 0;
  bool clothed = false;    // the synthetic person
  std::string truth_path;  // "": truth.json in the folder, NAME.truth.json beside NAME.oni
  int reconnect_s = 0;     // a camera that went away is waited for so long; -1: for ever
  // Called when the camera went away or came back; unset: a line on stderr.
  std::function<void(const hal::ReconnectStats&, const hal::SourceInfo&)> camera_changed;
};
void add_input_options(cli::App& sub, InputOptions& options);
// --reconnect; the default is options.reconnect_s.
void add_reconnect_option(cli::App& sub, InputOptions& options);

struct Input {
  std::unique_ptr<hal::Source> source;
  std::optional<Truth> truth;
};
Result<Input> open_input(const InputOptions& options);

// True once the person at the keyboard pressed Ctrl-C, or SIGTERM came (after catch_interrupt).
void catch_interrupt();
bool interrupted();

// A source that ends after a number of frames or at Ctrl-C, shows each frame's number to `watch`, keeps the first
// error of a damaged one.
class FrameTap final : public hal::Source {
 public:
  using Watch = std::function<void(std::uint64_t frame_count)>;
  FrameTap(hal::Source& source, std::uint64_t frame_count_max, Watch watch);
  const hal::SourceInfo& info() const override { return source_.info(); }
  Status start() override { return source_.start(); }
  Result<hal::FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override { source_.stop(); }
  // `held` is called before every frame. While it returns true, next() returns no frame and keeps waiting: frames of
  // a camera are dropped, a recording stands still.
  void hold_while(std::function<bool()> held) { held_ = std::move(held); }
  bool lost() const override { return source_.lost(); }
  std::optional<Vec3f> down() const override { return source_.down(); }
  hal::SourceStats stats() const override { return source_.stats(); }
  const std::optional<Error>& first_damage() const { return first_damage_; }

 private:
  std::optional<Error> wait_while_held(DepthImage depth, int timeout_ms);
  hal::Source& source_;
  std::uint64_t frame_count_max_;
  Watch watch_;
  std::function<bool()> held_;
  std::uint64_t frame_count_ = 0;
  std::optional<Error> first_damage_;
};

}  // namespace im2fit::apps
