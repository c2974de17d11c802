// SPDX-License-Identifier: Apache-2.0
// Converts frames of phones and cameras (im2fit_frame) for the engine: upright 16-bit millimetres with one set of
// intrinsics.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "capi/include/im2fit/im2fit.h"
#include "core/camera.h"
#include "core/lazy_zeros.h"
#include "core/status.h"
#include "engine/engine.h"
#include "hal/steady_view.h"
#include "hal/undistort.h"

namespace im2fit::c {

// One thread at a time. Allocates only in prepare(), and for the first frame that has a lens or a pose.
class FrameReader {
 public:
  // `upright`: the settings' intrinsics.
  void prepare(const Intrinsics& upright);
  // A new session: the next frame's intrinsics, and its view, are the session's.
  void forget() {
    told_ = false;
    if (steady_) steady_->forget();
  }
  const Intrinsics& session() const { return session_; }
  // Reads `frame` and pushes it. Errors: invalid_argument naming the field; the engine's.
  Status push(Engine& engine, const im2fit_frame& frame);

 private:
  Status take_intrinsics(Engine& engine, const im2fit_frame& frame);
  void resample(DepthView from, DepthImage to) const;
  void take_pose(const im2fit_frame& frame);
  Status commit(Engine& engine, DepthImage place, const im2fit_frame& frame);
  Status take_lens(const im2fit_frame& frame);
  void undistort(DepthImage to) const;

  Intrinsics settings_;  // the engine's for frames without their own
  Intrinsics session_;   // the engine's
  bool told_ = false;
  bool resample_ = false;
  // A frame through a lens: from the camera's picture straight to the session's.
  struct Lens {
    Intrinsics camera, session;
    int rotate_deg = 0;
    hal::Distortion distortion;
    bool same_as(const Lens& other) const;
  };
  bool undistort_ = false;
  Lens lens_;                              // of the table
  std::vector<std::int32_t> table_;        // for each pixel of the session's picture the camera's; -1: outside
  LazyZeros<std::uint16_t> camera_;        // a frame that is to be turned
  LazyZeros<std::uint16_t> upright_;       // one that is to be resampled; others go straight into the engine's place
  std::optional<hal::SteadyView> steady_;  // from the first pose on
  bool posed_ = false, moves_ = false;     // the current frame has a pose; one other than the view's
  std::vector<std::int32_t> columns_, rows_;  // of a resampled picture: where its samples come from; -1: outside
};

}  // namespace im2fit::c
