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
  std::string uri;        // the normalised argument of open()
  std::string name;       // vendor and model, or the path
  std::string serial;     // "" when there is none
  Intrinsics intrinsics;  // of the frames next() delivers: after rotation
  IntrinsicsOrigin intrinsics_origin = IntrinsicsOrigin::device;
  int rotate_deg = 0;
  SensorKind sensor = SensorKind::unknown;  // if the camera is known
  bool live = false;                        // live sources may drop frames; others do not
  std::int64_t frame_count = -1;            // -1: not known or endless
  double unit_mm = 1;  // unit of a folder's stored pixels, which --unit replaces; frames are in millimetres
};

// Transforms from the axes of a frame (x right, y down, z forward) to static axes: a rotation by a unit quaternion,
// then a translation by the position of the camera.
struct CameraPose {
  float x = 0, y = 0, z = 0, w = 1;
  Vec3f position_mm;
};

// The pixels are in the caller's buffer: next() fills `depth`.
struct FrameInfo {
  std::uint64_t sequence = 0;   // the device's number if it has one, otherwise counted here from 0
  std::int64_t host_ns = 0;     // live: CLOCK_MONOTONIC at arrival. Recordings: the clock of the recording, so that
                                // a replay gives the same bits at any speed
  std::int64_t device_us = -1;  // device ticks in microseconds; -1: none
  std::optional<Vec3f> down = {};  // unit vector, axes of the delivered frame; none: unchanged
  // Pose of a moving camera for the delivered frame. The engine resamples such frames to a static view
  // (hal/steady_view.h). None: the camera is static.
  std::optional<CameraPose> pose = {};
};

struct SourceStats {
  std::uint64_t delivered = 0;
  std::uint64_t gaps = 0;     // skipped sequence numbers
  std::uint64_t repeats = 0;  // repeated sequence numbers
  std::uint64_t damaged = 0;  // rejected frames
};

// Threads: one thread calls start, next and stop. Any thread may close the source after next has returned.
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
  // The direction of gravity from an accelerometer, a unit vector in the axes of the delivered frames (x right, y
  // down, z forward). None: the camera has no accelerometer or is moving.
  virtual std::optional<Vec3f> down() const { return std::nullopt; }
  // The camera is disconnected and may return (ReconnectingSource). Until then next() returns timeout.
  virtual bool lost() const { return false; }
};

// The direction of gravity for the latest frame: that of the frame or, about once per second, source.down(), which
// uses the same bus as the frames. None: unchanged.
inline std::optional<Vec3f> down_of(const Source& source, const FrameInfo& frame) {
  constexpr std::uint64_t kDownEvery = 30;  // frames, about a second
  if (frame.down || frame.sequence % kDownEvery != 0) return frame.down;
  return source.down();
}

// The upright picture of a camera that is mounted rotated. W x H is the size of `in`:
//    90: upright(u, v) = in(v, H - 1 - u)            `out` is H wide and W high
//   180: upright(u, v) = in(W - 1 - u, H - 1 - v)
//   270: upright(u, v) = in(W - 1 - v, u)            the inverse of 90
// `rotate_deg` is 0, 90, 180 or 270 (is_rotation()), `out` has the upright size and does not overlap `in`.
void rotate_upright(DepthView in, int rotate_deg, DepthImage out);
Intrinsics rotate_upright(const Intrinsics& in, int rotate_deg);
Vec3f rotate_upright(Vec3f in, int rotate_deg);  // a direction in the camera's axes
// The static axes are rotated with the frame, so a pose that is upright in its frames stays upright.
CameraPose rotate_upright(const CameraPose& delivered, int rotate_deg);
bool is_rotation(int rotate_deg);
// `what` names the file or device in the error.
Status check_intrinsics(const Intrinsics& k, const std::string& what);  // finite, positive, plausible, size 1..2048

}  // namespace im2fit::hal
