// SPDX-License-Identifier: Apache-2.0
// A camera's calibration as ROS (camera_info) and OpenCV (FileStorage) write it.
#pragma once

#include <optional>
#include <string>

#include "base/status.h"
#include "hal/source.h"

namespace im2fit::hal {

struct CameraFile {
  Intrinsics intrinsics;                                         // of the camera's picture, before rotation
  std::optional<int> rotate_deg;                                 // im2fit_rotate_deg, where the file has it
  IntrinsicsOrigin origin = IntrinsicsOrigin::calibration_file;  // im2fit_intrinsics_origin, where the file has it
};

// Keys: image_width, image_height, camera_matrix (3 x 3, `data`), distortion_coefficients (must be zeros: the
// pictures must be undistorted). Errors name the file and the key: not_found, io, corrupt (no YAML), invalid_argument
// (values no camera has), unsupported (distortion).
Result<CameraFile> load_camera_yaml(const std::string& path);

}  // namespace im2fit::hal
