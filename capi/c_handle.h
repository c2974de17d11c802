// SPDX-License-Identifier: Apache-2.0
// The opaque handle of include/im2fit/im2fit.h. Only the C functions and their test include this.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "body/skeleton.h"
#include "capi/frame.h"
#include "capi/include/im2fit/im2fit.h"
#include "capi/mask_keeper.h"
#include "capi/status_of.h"
#include "engine/frame_stages.h"
#include "person/measuring_data.h"

// The source that an opener opened, as a source of the engine; closed on destruction.
class OpenedSource final : public im2fit::hal::Source {
 public:
  OpenedSource(const im2fit_source& opened, im2fit_down_fn down, const im2fit::hal::SourceInfo& info)
      : opened_(opened), down_(down), info_(info) {}
  ~OpenedSource() override {
    if (opened_.close != nullptr) opened_.close(opened_.user);
  }
  OpenedSource(const OpenedSource&) = delete;
  OpenedSource& operator=(const OpenedSource&) = delete;
  const im2fit::hal::SourceInfo& info() const override { return info_; }
  im2fit::Status start() override { return im2fit::Ok{}; }
  im2fit::Result<im2fit::hal::FrameInfo> next(im2fit::DepthImage depth, int timeout_ms) override;
  void stop() override {}
  im2fit::hal::SourceStats stats() const override { return {}; }
  int status() const { return status_; }  // the opener's status for the latest frame
  void forget_status() { status_ = IM2FIT_OK; }

 private:
  im2fit_source opened_;
  im2fit_down_fn down_;  // null: it does not measure gravity
  im2fit::hal::SourceInfo info_;
  int status_ = IM2FIT_OK;
};

struct im2fit_handle {
  // In the order of references between them: the engine is destroyed first, the files last.
  im2fit::MeasuringData data;
  im2fit::hal::SourceInfo origin;  // the known properties of the source
  std::int32_t frames_wanted = 0;  // as the settings
  std::unique_ptr<im2fit::c::MaskKeeper> mask = std::make_unique<im2fit::c::MaskKeeper>();  // the engine writes to it
  std::unique_ptr<im2fit::Engine> engine;
  // Of the measured person, made when first requested: it stays unchanged until the next session.
  std::optional<im2fit::PersonMeasurement> person;

  // Of the same person, made when first requested.
  struct Dressed {
    std::string worn;  // which garments in which sizes
    std::vector<std::byte> glb;
  };
  Dressed dressed;
  struct Skeleton {
    im2fit::body::Skeleton rest;
    float floor_mm = 0;  // under it
  };
  std::optional<Skeleton> skeleton;
  void forget_person() {
    person.reset();
    dressed = {};
    skeleton.reset();
  }

  // The session that im2fit_next ended: facts are of the one after it, though the measured person has not left.
  std::optional<std::uint32_t> next_after;

  im2fit_log_fn log = nullptr;
  void* log_user = nullptr;
  std::array<char, 512> error{};
  int process = 0;  // that opened it
  im2fit::c::FrameReader frames;

  im2fit_opener_fn opener = nullptr;
  void* opener_user = nullptr;
  im2fit_down_fn opener_down = nullptr;
  std::unique_ptr<OpenedSource> source;  // null: nothing is attached

  // In a forked child: the engine's threads and the source are the parent's, neither can be stopped from here.
  void leave_to_parent() {
    static_cast<void>(engine.release());
    static_cast<void>(source.release());
  }
};

namespace im2fit {

// `stages` null: the production stages, from the settings' files. Otherwise paths of tracker and index are not used.
Result<std::unique_ptr<im2fit_handle>> open_c_handle(const im2fit_settings& settings,
                                                     std::unique_ptr<FrameStages> stages);

}  // namespace im2fit
