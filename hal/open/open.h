// SPDX-License-Identifier: Apache-2.0
// From the SOURCE word of the command line to a source, whatever this build can open.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/reconnecting_source.h"
#include "hal/source.h"

namespace im2fit::hal {

struct OpenOptions {
  std::optional<int> rotate_deg;  // how the camera is mounted; unset: what the recording says, else 0
  std::string camera_yaml_path;   // a calibration that overrides the camera's own; "" for none
  int width = 640;                // wanted of a live camera, before rotation
  int height = 480;
  int stall_ms = 5000;  // a recording that gives nothing for so long is damaged
  // Opens `synthetic[:seed]`; `seed` is "" when not given. Unset: such a source is refused. Kept out of hal because
  // the synthetic person needs the body and synth.
  std::function<Result<std::unique_ptr<Source>>(const std::string& seed, const OpenOptions& options)> synthetic;
};

// `uri`: openni2[:URI] | usb[:SERIAL] | v4l2[:/dev/videoN][?key=value&...] | PATH.oni | DEPTH_FOLDER |
// synthetic[:seed].
Result<std::unique_ptr<Source>> open_source(const std::string& uri, const OpenOptions& options = {});

// Opens the live camera `uri` again and again, without leaking what its library leaks at each beginning. Empty when
// `uri` is no live camera.
ReconnectingSource::Opener camera_opener(const std::string& uri, const OpenOptions& options);
// The same as open_source; a camera may then be unplugged and come back (ReconnectingSource, docs/cameras.md). What
// is no live camera is returned as it is.
Result<std::unique_ptr<Source>> open_reconnecting(const std::string& uri, const OpenOptions& options,
                                                  const ReconnectOptions& reconnect);

struct DeviceEntry {
  std::string uri;   // what open_source takes, for example openni2:1d27/0600@1/4
  std::string name;  // vendor and model
};
// Cameras now connected. An empty list is no error; a runtime that cannot be started is, when there is no camera by
// any other way.
Result<std::vector<DeviceEntry>> list_devices();

struct OniRecording {
  std::string path;
  std::string camera_yaml_path;           // the calibration written beside it
  std::uint64_t frames_seen = 0;          // frames the reader took meanwhile; the file may hold a few more
  std::uint64_t pixels_beyond_range = 0;  // depths OpenNI2's codec cannot keep exactly (32768 mm and more)
};
// Records an OpenNI2 camera with the runtime's own recorder while the caller goes on calling next(). Begin before
// start() to keep the first frame. Errors: unsupported (no OpenNI2 camera), io.
Status begin_oni_recording(Source& source, const std::string& path);
Result<OniRecording> end_oni_recording(Source& source);

}  // namespace im2fit::hal
