// SPDX-License-Identifier: Apache-2.0
// A depth source: a camera, a recording, a folder, a synthetic person, or frames the caller pushes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/status.h"
#include "kernels/core/camera.h"

namespace im2fit::hal {

enum class IntrinsicsOrigin { device, calibration_file, recording, field_of_view, caller, synthetic };

struct SourceInfo {
  std::string uri;     // what open() was given, normalised
  std::string name;    // vendor and model, or the path
  std::string serial;  // "" when there is none
  Intrinsics intrinsics;  // of the frames next() delivers: after rotation
  IntrinsicsOrigin intrinsics_origin = IntrinsicsOrigin::device;
  int rotate_deg = 0;
  bool live = false;      // live sources may drop frames; the others never do
  std::int64_t frame_count = -1;  // -1: not known or endless
};

// Pixels belong to the caller's pool: next() fills `depth`.
struct FrameInfo {
  std::uint64_t sequence = 0;      // device's own where it has one, else counted here from 0
  std::int64_t host_ns = 0;        // CLOCK_MONOTONIC at arrival
  std::int64_t device_us = -1;     // device ticks in microseconds; -1 when it has none
};

struct SourceStats {
  std::uint64_t delivered = 0;
  std::uint64_t gaps = 0;       // sequence numbers skipped
  std::uint64_t repeats = 0;    // sequence numbers seen again
  std::uint64_t damaged = 0;    // frames refused
};

// Thread rules: one thread calls start/next/stop; close may follow from any thread once next has returned.
class Source {
 public:
  virtual ~Source() = default;
  virtual const SourceInfo& info() const = 0;
  virtual Status start() = 0;
  // Blocks up to `timeout_ms` for the next frame and writes it (rotated to upright) into `depth`, which has
  // info().intrinsics' size. Errors: timeout (call again), end_of_stream, no_device (lost), corrupt (this frame is
  // skipped; call again), io.
  virtual Result<FrameInfo> next(DepthImage depth, int timeout_ms) = 0;
  virtual void stop() = 0;
  virtual SourceStats stats() const = 0;
};

// Copies `in` rotated by `rotate_deg` counter-clockwise-mounting undone: the upright picture of a camera that was
// turned `rotate_deg` clockwise. `out` is height x width for 90 and 270.
void rotate_upright(DepthView in, int rotate_deg, DepthImage out);
Intrinsics rotate_upright(const Intrinsics& in, int rotate_deg);
Status check_intrinsics(const Intrinsics& k, const std::string& what);  // finite, positive, plausible, size 1..2048

}  // namespace im2fit::hal
