// SPDX-License-Identifier: Apache-2.0
// What is behind the opaque handle of include/im2fit/im2fit.h. Only the C functions and their test see it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/file.h"
#include "engine/c_api/frame.h"
#include "engine/engine.h"
#include "engine/frame_stages.h"
#include "engine/include/im2fit/im2fit.h"
#include "engine/size_chart.h"

struct im2fit_handle {
  // In the order of what refers to what: the engine goes first, the files last.
  im2fit::MappedFile tracker_file;
  std::vector<std::byte> tracker_bytes;  // of settings.tracker_data
  std::optional<im2fit::JointModel> tracker;
  std::optional<im2fit::index::Index> index;
  std::optional<im2fit::body::BodyModel> body;
  im2fit::SizeSystem sizes;
  int width = 0;
  int height = 0;
  std::unique_ptr<im2fit::Engine> engine;

  im2fit_log_fn log = nullptr;
  void* log_user = nullptr;
  std::array<char, 512> error{};
  int process = 0;  // that opened it
  im2fit::c::FrameReader frames;

  im2fit_opener_fn opener = nullptr;
  void* opener_user = nullptr;
  bool attached = false;
  im2fit_source source{};
  std::vector<std::uint16_t> source_pixels;

  im2fit_handle() = default;
  im2fit_handle(const im2fit_handle&) = delete;
  im2fit_handle& operator=(const im2fit_handle&) = delete;
  ~im2fit_handle() { close_source(); }
  void close_source() {
    if (attached && source.close != nullptr) source.close(source.user);
    attached = false;
  }
  // In a forked child: the engine's threads and the source are the parent's, neither can be stopped from here.
  void leave_to_parent() {
    static_cast<void>(engine.release());
    attached = false;
  }
};

namespace im2fit {

int status_of(ErrorCode code);

// `stages` null: the production stages, from the settings' files. Otherwise paths of tracker and index are not used.
Result<std::unique_ptr<im2fit_handle>> open_c_handle(const im2fit_settings& settings,
                                                     std::unique_ptr<FrameStages> stages);

}  // namespace im2fit
