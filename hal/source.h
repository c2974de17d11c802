// SPDX-License-Identifier: Apache-2.0
// A depth source: a camera, a recording, a folder or a synthetic person.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/sensor_kind.h"
#include "core/status.h"
#include "core/vec3.h"

namespace im2fit::hal {

enum class IntrinsicsOrigin { device, calibration_file, recording, field_of_view, caller, synthetic };

struct SourceInfo {
  std::string uri;        // the argument of open(), normalised
  std::string name;       // vendor and model, or the path
  std::string serial;     // "" when there is none
  Intrinsics intrinsics;  // of the frames next() delivers: after rotation
  IntrinsicsOrigin intrinsics_origin = IntrinsicsOrigin::device;
  int rotate_deg = 0;
  SensorKind sensor = SensorKind::unknown;  // where the camera is known
  bool live = false;                        // live sources may drop frames; the others never do
  std::int64_t frame_count = -1;            // -1: not known or endless
  double unit_mm = 1;  // of a folder's pixels as stored: what --unit replaces; frames are in millimetres
};

// From the axes of a frame (x right, y down, z forward) to those of a place at rest: directions by a unit quaternion,
// then `position_mm`, where the camera is.
struct CameraPose {
  float x = 0, y = 0, z = 0, w = 1;
  Vec3f position_mm;
};

// Pixels belong to the caller's pool: next() fills `depth`.
struct FrameInfo {
  std::uint64_t sequence = 0;      // device's own where it has one, else counted here from 0
  std::int64_t host_ns = 0;        // live: CLOCK_MONOTONIC at arrival. Recordings: the recording's own clock, so that
                                   // a replay gives the same bits however fast it runs
  std::int64_t device_us = -1;     // device ticks in microseconds; -1 when it has none
  std::optional<Vec3f> down = {};  // unit, axes of the frame delivered; none: as before
  // Of the frame delivered, from a camera that moves and tells where it is: the engine steadies its frames
  // (hal/steady_view.h). None: the camera stands still.
  std::optional<CameraPose> pose = {};
};

struct SourceStats {
  std::uint64_t delivered = 0;
  std::uint64_t gaps = 0;     // sequence numbers skipped
  std::uint64_t repeats = 0;  // sequence numbers seen again
  std::uint64_t damaged = 0;  // frames refused
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
  // The direction of down, a unit vector in the axes of the frames delivered (x right, y down, z forward), from a
  // camera with an accelerometer at rest. None: the camera has none, or is moving.
  virtual std::optional<Vec3f> down() const { return std::nullopt; }
  // The camera is away and may come back (ReconnectingSource): until then next() returns timeout.
  virtual bool lost() const { return false; }
};

// The direction of down for a frame just delivered: the frame's own or, about every second, source.down(), which uses
// the bus of the frames. None: unchanged.
inline std::optional<Vec3f> down_of(const Source& source, const FrameInfo& frame) {
  constexpr std::uint64_t kDownEvery = 30;  // frames, about a second
  if (frame.down || frame.sequence % kDownEvery != 0) return frame.down;
  return source.down();
}

// The upright picture of a camera that was turned when it was mounted. With W x H the size of `in`:
//    90: upright(u, v) = in(v, H - 1 - u)            `out` is H wide and W high
//   180: upright(u, v) = in(W - 1 - u, H - 1 - v)
//   270: upright(u, v) = in(W - 1 - v, u)            the inverse turn of 90
// `rotate_deg` is 0, 90, 180 or 270 (is_rotation()), `out` has the upright size and does not overlap `in`.
void rotate_upright(DepthView in, int rotate_deg, DepthImage out);
Intrinsics rotate_upright(const Intrinsics& in, int rotate_deg);
Vec3f rotate_upright(Vec3f in, int rotate_deg);  // a direction in the camera's axes
// The place at rest is turned along with the frame, so that one that is upright in its frames stays so.
CameraPose rotate_upright(const CameraPose& delivered, int rotate_deg);
bool is_rotation(int rotate_deg);
// `what` names the file or device in the error.
Status check_intrinsics(const Intrinsics& k, const std::string& what);  // finite, positive, plausible, size 1..2048

}  // namespace im2fit::hal
