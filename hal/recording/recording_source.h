// SPDX-License-Identifier: Apache-2.0
// A recording in one file as a source: its reader delivers the camera's pictures, and what every source does with
// them is done here.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hal/frame_path.h"
#include "hal/source.h"

namespace im2fit::hal {

inline constexpr std::int64_t kRecordedTimeMaxNs = 4'000'000'000'000'000'000;  // the year 2096, by any clock

class FrameReader {
 public:
  virtual ~FrameReader() = default;
  virtual Status rewind() = 0;
  // The next picture in millimetres, as the camera stored it, into `picture` of the calibration's size. `down` is in
  // the axes of that picture. Errors:
  // corrupt (this picture is skipped; call again), end_of_stream, io.
  virtual Result<FrameInfo> next(DepthImage picture) = 0;
};

struct RecordingOptions {
  std::optional<int> rotate_deg;  // overrides the calibration's; 0 when neither specifies it
  std::string camera_yaml_path;   // "" for the calibration in the recording
};

struct RecordingAbout {
  std::string path;
  Calibration calibration;       // its origin is kept
  std::string calibration_path;  // for errors
  SensorKind sensor = SensorKind::unknown;
  std::int64_t frame_count = -1;
};

// Replays every frame in order, as fast as it is read. Errors: a calibration that is not plausible.
Result<std::unique_ptr<Source>> recording_source(const RecordingAbout& about, const RecordingOptions& options,
                                                 std::unique_ptr<FrameReader> reader);

}  // namespace im2fit::hal
