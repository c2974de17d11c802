// SPDX-License-Identifier: Apache-2.0
// The streaming engine in C++: two threads, lock-free rings over a frame pool made at start, session states.
// Other languages and other compilers use include/im2fit/im2fit.h, which wraps this.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "base/status.h"
#include "body/model.h"
#include "hal/source.h"
#include "index/index.h"
#include "kernels/core/guidance.h"
#include "kernels/core/joints.h"
#include "kernels/observe/observe.h"

namespace im2fit {

enum class SessionState : int { searching, user_found, calibrating, tracking, measured, lost };

struct EngineSettings {
  int width = 640, height = 480;     // of upright frames
  Intrinsics intrinsics;
  int frames_wanted = 30;            // accepted frames until MEASURED
  int frames_min = 5;                // fewest a measurement may rest on when the stream ends
  bool calibration_psi = false;      // ask for the Psi pose first, as the paper does
  bool live = false;                 // live: drop the oldest frame when behind; else wait (replay never drops)
  bool single_thread = false;        // both halves on the caller's thread in push(): same bits
  int pool_frames = 8;
};

// Immutable snapshot; plain data, no allocation to copy.
struct EngineResult {
  SessionState state = SessionState::searching;
  GuidanceSet guidance = 0;          // of the latest frame
  GuidanceSet guidance_seen = 0;     // of all frames so far
  std::uint64_t frames_seen = 0, frames_used = 0, frames_dropped = 0;
  bool has_joints = false;
  JointSet joints;                   // latest
  FloorPlane floor;
  bool measured = false;
  index::Answer answer;              // valid when measured
  MeasurementValues paper{};         // NaN where not measured
  JointSet measured_joints;          // robust mean behind the answer
};

class Engine {
 public:
  // The model and index must outlive the engine.
  static Result<std::unique_ptr<Engine>> create(const EngineSettings& settings, const JointModel& joint_model,
                                                const index::Index& index);
  virtual ~Engine() = default;
  // From one producer thread. Copies the frame into the pool; blocks when full unless live. After finish(): error.
  virtual Status push(DepthView depth, const hal::FrameInfo& info) = 0;
  // No more frames: waits until both halves are idle and measures with what there is.
  virtual void finish() = 0;
  // Any thread, any time, never blocks the pipeline.
  virtual EngineResult result() const = 0;
  virtual void reset() = 0;  // a new person; after finish() or between frames
  // For overlays, after finish(): the fused picture. Empty views when there is none.
  virtual ImageView<const std::uint16_t> fused_depth_q4() const = 0;
  virtual MaskView fused_mask() const = 0;
};

// Pulls from `source` until end, loss or `measured`.
Status run(Engine& engine, hal::Source& source, bool stop_when_measured);

}  // namespace im2fit
