// SPDX-License-Identifier: Apache-2.0
// A camera's calibration as ROS (calibration file, camera_info echoed from a topic), OpenCV (FileStorage), Open3D and
// the makers of cameras write it; JSON is YAML.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/status.h"
#include "hal/intrinsics.h"

namespace im2fit::hal {

struct CameraFile : Calibration {
  std::optional<std::uint32_t> oni_crc32c;  // of the .oni recording the file lies beside
  std::optional<int> confidence_min;        // 0..255; of a folder's confidence/NNNNNN.png
};

// Keys: image_width, image_height, camera_matrix (3 x 3, `data`), distortion_coefficients (4, 5 or 8 of them; absent:
// none), distortion_model (plumb_bob, rational_polynomial; absent: plumb_bob), and of our own im2fit_rotate_deg,
// im2fit_intrinsics_origin, im2fit_oni_crc32c and im2fit_confidence_min. Errors name the file and the key: not_found,
// io, corrupt (no YAML), invalid_argument (values no camera has), unsupported (another distortion model).
Result<CameraFile> load_camera_yaml(const std::string& path);
// The same for a file's contents; `path` names the file in errors.
Result<CameraFile> parse_camera_yaml(const std::string& text, const std::string& path);

}  // namespace im2fit::hal
