// SPDX-License-Identifier: Apache-2.0
// A camera's calibration as ROS (calibration file, camera_info echoed from a topic), OpenCV (FileStorage, YAML and
// XML), Open3D, kalibr, the makers of cameras and the recorders of phones write it; JSON is YAML.
#pragma once

#include <array>
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
// im2fit_intrinsics_origin, im2fit_oni_crc32c and im2fit_confidence_min; or the words of others
// (calibration_words.h). `pictures` is needed where a file has no size or several modes. Errors name the file and the
// key: not_found, io, corrupt (no YAML), invalid_argument (values no depth camera has: a field of view under 25 or
// over 130 degrees, a centre outside the middle half of the picture or that of turned pictures), unsupported (another
// distortion model, an unknown key that looks like a part of a lens).
Result<CameraFile> load_camera_yaml(const std::string& path, PictureSize pictures = {});
// The same for a file's contents; `path` names the file in errors.
Result<CameraFile> parse_camera_yaml(const std::string& text, const std::string& path, PictureSize pictures = {});

// Of an Azure Kinect's calibration.json: the rotation from the depth camera's axes to those of the accelerometer, row
// by row. None: the text has none.
std::optional<std::array<float, 9>> accelerometer_rotation(const std::string& text);

}  // namespace im2fit::hal
