// SPDX-License-Identifier: Apache-2.0
// A recording of Stray Scanner, an app of iPhones and iPads with LiDAR, as it leaves the phone:
//
//   camera_matrix.csv       3 x 3, of the colour picture of 1920 x 1440
//   odometry.csv            the phone's pose for each frame, as ARKit tracks it
//   depth/NNNNNN.png        16-bit grey, mm
//   confidence/NNNNNN.png   8-bit grey: 0, 1, 2 (optional)
//
// rgb.mp4 and imu.csv are not read.
#pragma once

#include <memory>
#include <string>

#include "hal/folder/depth_folder.h"

namespace im2fit::hal {

// A folder with depth/ and odometry.csv or camera_matrix.csv, without camera.yaml.
bool is_stray_scanner(const std::string& path);

// The frames with pose, gravity and time. The intrinsics are those of the colour picture, scaled; the pictures are
// turned upright by the gravity of the first pose. Without odometry.csv (a phone on a stand) the phone is taken to be
// held upright, and frames to be 1/60 s apart. `options` may replace calibration and rotation. Errors name the file:
// not_found, corrupt, invalid_argument (sizes that do not belong together), unsupported (.npy of the app's first
// versions), io.
Result<std::unique_ptr<FolderSource>> open_stray_scanner(const std::string& path, const FolderOptions& options);

}  // namespace im2fit::hal
