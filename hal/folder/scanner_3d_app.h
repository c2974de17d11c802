// SPDX-License-Identifier: Apache-2.0
// A recording of 3D Scanner App (iPhones and iPads with LiDAR), exported with all its data:
//
//   depth_NNNNN.png   16-bit grey, mm
//   conf_NNNNN.png    8-bit grey: 0, 1, 2 (optional)
//   frame_NNNNN.json  of the colour picture: intrinsics (3 x 3), cameraPoseARFrame (4 x 4 row by row; ARKit's axes: x
//                     right, y up, z backwards), time in seconds
//
// Colour pictures and meshes are not read.
#pragma once

#include <memory>
#include <string>

#include "hal/folder/depth_folder.h"
#include "hal/folder/pose_rows.h"

namespace im2fit::hal {

// A folder with depth_NNNNN.png and frame_NNNNN.json of one number, without camera.yaml.
bool is_scanner_3d_app(const std::string& path);

// As open_phone_recording. Each frame needs its frame_NNNNN.json. Errors name the file: not_found, corrupt,
// invalid_argument, io.
Result<std::unique_ptr<FolderSource>> open_scanner_3d_app(const std::string& path, const FolderOptions& options);

// The text of a frame_NNNNN.json; `path` names the file in errors. PoseRow::sequence and line are left alone.
Result<PoseRow> parse_app_frame(const std::string& text, const std::string& path);

}  // namespace im2fit::hal
