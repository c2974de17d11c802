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
  double unit_mm = 0;             // of a folder's pixels or a scan's lengths; 0: as it has them, as fits a person
  std::string scan_up;            // the axis of a scan that points up (ScanOptions::up); "": found
  int width = 640;                // wanted of a live camera, before rotation
  int height = 480;
  int stall_ms = 5000;  // a recording that gives nothing for so long is damaged
  // Opens `synthetic[:seed]`; `seed` is "" when not given. Unset: such a source is refused. Kept out of hal because
  // the synthetic person needs the body and the lab.
  std::function<Result<std::unique_ptr<Source>>(const std::string& seed, const OpenOptions& options)> synthetic;
};

// `uri`: openni2[:URI] | usb[:SERIAL] | v4l2[:/dev/videoN][?key=value&...] | PATH.oni | PATH.mkv (Azure Kinect,
// Femto) | PATH.bag (RealSense, ROS 1) | PATH.zip (of a folder) | DEPTH_FOLDER | STRAY_SCANNER_FOLDER |
// SCANNER_APP_FOLDER | TUM_FOLDER | SCAN.ply, .obj, .glb, .pcd | synthetic[:seed]. A scan is looked at from the
// front, then walked round (hal/scan/scan_source.h). A recording of another make is refused with the command that
// converts it (hal/folder/other_recordings.h).
Result<std::unique_ptr<Source>> open_source(const std::string& uri, const OpenOptions& options = {});

// Whether open_source reads `uri` as a scan, by its name; a folder is none.
bool is_scan(const std::string& uri);

// Opens the live camera `uri` repeatedly, without the leak of its library at each initialisation. Empty when `uri` is
// not a live camera.
ReconnectingSource::Opener camera_opener(const std::string& uri, const OpenOptions& options);
// The same as open_source; a live camera may then be unplugged and come back (ReconnectingSource, docs/cameras).
// Other sources are returned unchanged.
Result<std::unique_ptr<Source>> open_reconnecting(const std::string& uri, const OpenOptions& options,
                                                  const ReconnectOptions& reconnect);

struct DeviceEntry {
  std::string uri;   // what open_source takes, for example openni2:1d27/0600@1/4
  std::string name;  // vendor and model
};
// Cameras now connected. An empty list is a success. Errors: a runtime cannot be started, and no other backend has a
// camera.
Result<std::vector<DeviceEntry>> list_devices();

}  // namespace im2fit::hal
