// SPDX-License-Identifier: Apache-2.0
// Opens the SOURCE of the command line, of any kind that this build supports.
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
  std::optional<int> rotate_deg;  // mounting of the camera; unset: as stored in the recording, or 0
  std::string camera_yaml_path;   // a calibration that replaces the camera's own; "": none
  double unit_mm = 0;   // unit of a folder's pixels or a scan's lengths; 0: the folder's own; scan: estimated
  std::string scan_up;  // the axis of a scan that points up (ScanOptions::up); "": estimated
  int width = 640;      // preferred size of a live camera, before rotation
  int height = 480;
  int stall_ms = 5000;  // a recording without a frame for this time is damaged
  // Opens `synthetic[:seed]`; `seed` is "" if not given. Unset: such a source is rejected. It is not part of hal,
  // because the synthetic person needs the body and the lab.
  std::function<Result<std::unique_ptr<Source>>(const std::string& seed, const OpenOptions& options)> synthetic;
};

// `uri`: openni2[:URI] | usb[:SERIAL] | v4l2[:/dev/videoN][?key=value&...] | PATH.oni | PATH.mkv (Azure Kinect,
// Femto) | PATH.bag (RealSense, ROS 1) | PATH.zip (of a folder) | DEPTH_FOLDER | STRAY_SCANNER_FOLDER |
// SCANNER_APP_FOLDER | TUM_FOLDER | SCAN.ply, .obj, .glb, .pcd | synthetic[:seed]. A scan is rendered from the front,
// then from all sides (hal/scan/scan_source.h). The error for an unsupported recording names the command that
// converts it (hal/folder/other_recordings.h).
Result<std::unique_ptr<Source>> open_source(const std::string& uri, const OpenOptions& options = {});

// Whether open_source reads `uri` as a scan, by its name; a folder is none.
bool is_scan(const std::string& uri);

// Returns a function that opens the live camera `uri` repeatedly without the leak that its library has at each
// initialisation. Empty if `uri` is not a live camera.
ReconnectingSource::Opener camera_opener(const std::string& uri, const OpenOptions& options);
// The same as open_source; a live camera may then be unplugged and come back (ReconnectingSource, docs/cameras).
// Other sources are returned unchanged.
Result<std::unique_ptr<Source>> open_reconnecting(const std::string& uri, const OpenOptions& options,
                                                  const ReconnectOptions& reconnect);

struct DeviceEntry {
  std::string uri;   // argument of open_source, for example openni2:1d27/0600@1/4
  std::string name;  // vendor and model
};
// Lists the connected cameras. An empty list is a success. Errors: a runtime cannot be started, and no other backend
// has a camera.
Result<std::vector<DeviceEntry>> list_devices();

}  // namespace im2fit::hal
