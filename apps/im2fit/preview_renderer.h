// SPDX-License-Identifier: Apache-2.0
// Who watches the engine at work: draws its frames into files and into the terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "apps/im2fit/terminal_view.h"
#include "engine/engine.h"

namespace im2fit::apps {

struct PreviewRendererOptions {
  std::string overlay;    // folder for NNNNNN.png; "": none
  int overlay_every = 1;  // of how many frames one is drawn
  bool view = false;      // in the terminal, ten times a second
};

// `see` on the engine's thread; the rest while the engine is idle (before the first push, after finish()).
class PreviewRenderer {
 public:
  PreviewRenderer(PreviewRendererOptions options, const Intrinsics& intrinsics, int frames_wanted);
  void see(const FrameSeen& frame);
  // What is shown under the picture until the next one, for example the last person's measurements.
  void say(std::string line) { last_word_ = std::move(line); }
  const std::optional<Error>& error() const { return error_; }  // the first; nothing is drawn after it
  std::uint64_t pictures() const { return pictures_; }

 private:
  void write_picture(const FrameSeen& frame);
  void show_picture(const FrameSeen& frame);

  PreviewRendererOptions options_;
  Intrinsics intrinsics_;
  int frames_wanted_;
  std::unique_ptr<TerminalView> view_;
  std::uint64_t frames_ = 0;
  std::uint64_t pictures_ = 0;
  std::chrono::steady_clock::time_point shown_{};
  std::string last_word_;
  std::optional<Error> error_;
};

// What a person in TURNING is asked to do; "" in other states.
std::string turn_words(const EngineResult& result);
// "TRACKING  user 2  front  12 of 30 good frames"
std::string state_words(const EngineResult& result, int frames_wanted);

}  // namespace im2fit::apps
