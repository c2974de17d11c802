// SPDX-License-Identifier: Apache-2.0
// The Kinect's foot: a motor that tilts the head and an accelerometer in the head.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/status.h"
#include "core/vec3.h"
#include "hal/usb/usb_transport.h"

namespace im2fit::hal {

class KinectMotor {
 public:
  KinectMotor(std::unique_ptr<UsbTransport> transport, std::string what)
      : transport_(std::move(transport)), what_(std::move(what)) {}

  struct State {
    Vec3f acceleration_g;           // as the sensor feels it: of a head at rest, up; x left, y up, z forward
    std::optional<float> tilt_deg;  // of the head from the horizon, up positive; none while it moves
    bool moving = false;
    bool at_limit = false;
  };
  // Errors: no_device, io, timeout.
  Result<State> state();
  // Starts tilting the head to `tilt_deg`, -31 to 31; a second or two. Errors: invalid_argument, and as above.
  Status set_tilt(float tilt_deg);
  // Down in the axes of the unrotated picture (x right, y down, z forward), a unit vector. None: the head is moving,
  // the acceleration is not gravity's, or the motor does not answer.
  std::optional<Vec3f> down();

 private:
  std::unique_ptr<UsbTransport> transport_;
  std::string what_;
};

}  // namespace im2fit::hal
