// SPDX-License-Identifier: Apache-2.0
// A recording in the layout of TUM's RGB-D benchmark, which programs for SLAM write:
//
//   depth.txt         a row a frame: timestamp in seconds, path of the picture; # begins a comment
//   depth/*.png       16-bit grey, 5000 units a metre
//   groundtruth.txt   optional: timestamp tx ty tz qx qy qz qw, the camera's pose in metres, from its axes (x right,
//   y
//                     down, z forward) to a world at rest
//
// Without depth.txt, pictures of depth/ whose names are times.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/folder/depth_folder.h"

namespace im2fit::hal {

inline constexpr double kTumUnitMm = 0.2;

// A folder with depth.txt, or with depth/ of pictures that are named by times.
bool is_tum_folder(const std::string& path);

// A frame without a pose within 50 ms has none. Without --camera and camera.yaml the pictures have 640 x 480 pixels,
// and the lens is the benchmark's: fx = fy = 525, cx = 319.5, cy = 239.5, reported as field_of_view.
// `options.unit_mm` other than 0 replaces the unit. Errors name file and line: not_found, corrupt, invalid_argument,
// unsupported, io.
Result<std::unique_ptr<FolderSource>> open_tum_folder(const std::string& path, const FolderOptions& options);

// A row of depth.txt or groundtruth.txt, for tests and fuzzers. `what` names the file.
struct TumFrame {
  double time_s = 0;
  std::string file;
};
struct TumPose {
  double time_s = 0;
  CameraPose pose;
};
Result<std::vector<TumFrame>> parse_tum_frames(const std::string& text, const std::string& what);
Result<std::vector<TumPose>> parse_tum_poses(const std::string& text, const std::string& what);

}  // namespace im2fit::hal
