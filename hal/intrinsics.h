// SPDX-License-Identifier: Apache-2.0
// Intrinsics from and to the values reported by cameras and files.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hal/source.h"
#include "hal/undistort.h"

namespace im2fit::hal {

std::string_view to_string(IntrinsicsOrigin origin);
std::optional<IntrinsicsOrigin> parse_origin(std::string_view text);

// Fields of view in radians, of the whole picture; the principal point is the picture's centre ((w - 1) / 2), all
// that an OpenNI2 device reports. Error: invalid_argument when the angles are implausible; `what` names the camera.
Result<Intrinsics> intrinsics_from_field_of_view(int width, int height, float horizontal_rad, float vertical_rad,
                                                 const std::string& what);
struct FieldOfView {
  float horizontal_rad = 0;
  float vertical_rad = 0;
};
FieldOfView field_of_view(const Intrinsics& k);

// What no depth camera has, and a mistake would have: check_intrinsics allows more.
enum class LensFault {
  none,
  field_of_view,     // along the wider side, beyond kFieldMinDeg to kFieldMaxDeg
  centre_turned,     // of pictures turned by 90 degrees
  centre_elsewhere,  // off the middle of both sides: of pictures of another size
};
inline constexpr float kFieldMinDeg = 25, kFieldMaxDeg = 130;  // Kinect: 57; Azure Kinect, wide: 120
float widest_field_deg(const Intrinsics& k);
// Focal lengths above 0, sides of a pixel or more.
LensFault lens_fault(const Intrinsics& k);

// Of the pictures that a calibration is for; 0: not known.
struct PictureSize {
  int width = 0;
  int height = 0;
  bool known() const { return width > 0 && height > 0; }
};

// The contents of a calibration file, for a camera's picture before rotation.
struct Calibration {
  Intrinsics intrinsics;
  Distortion distortion;
  std::optional<int> rotate_deg;  // how the camera was mounted, if in the file
  IntrinsicsOrigin origin = IntrinsicsOrigin::calibration_file;
};

// A calibration as ROS and OpenCV write it, values exact to the last bit of the float. `rotate_deg` is kept under
// im2fit_rotate_deg: how the camera was mounted when these pictures were made. `origin` is kept under
// im2fit_intrinsics_origin: where the values came from, so that a replay does not take a field of view for a
// calibration.
std::string camera_yaml_text(const Calibration& calibration, const std::string& camera_name);

}  // namespace im2fit::hal
