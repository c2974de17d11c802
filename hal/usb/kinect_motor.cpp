// SPDX-License-Identifier: Apache-2.0
#include "hal/usb/kinect_motor.h"

#include <array>

#include "hal/usb/kinect_protocol.h"

namespace im2fit::hal {
namespace {

using namespace kinect;

constexpr int kTransfer_ms = 250;
// At rest the sensor feels 1 g, give or take its own error (zero offset and sensitivity: some percent). Beyond it the
// head is being pushed.
constexpr float kRestMin_g = 0.85F;
constexpr float kRestMax_g = 1.15F;

float counts(const std::uint8_t* p) {
  return static_cast<float>(static_cast<std::int16_t>(static_cast<std::uint16_t>(p[0] << 8 | p[1])));
}

}  // namespace

Result<KinectMotor::State> KinectMotor::state() {
  std::array<std::uint8_t, kMotorStateBytes> bytes{};
  const auto got = transport_->control_in({kRequestIn, kMotorState, 0, 0}, bytes, kTransfer_ms);
  if (!got) return Error{got.error().code, what_ + ": the motor does not report its state: " + got.error().message};
  if (*got != bytes.size())
    return Error{ErrorCode::io, what_ + ": the motor reports its state in " + std::to_string(*got) +
                                    " bytes, expected " + std::to_string(bytes.size())};
  State state;
  const float per_count_g = 1.0F / static_cast<float>(kCountsPerG);
  state.acceleration_g = Vec3f{counts(&bytes[2]), counts(&bytes[4]), counts(&bytes[6])} * per_count_g;
  const auto tilt = static_cast<std::int8_t>(bytes[8]);
  state.moving = bytes[9] == kMoving || tilt == kTiltUnknown;
  state.at_limit = bytes[9] == kAtLimit;
  if (!state.moving) state.tilt_deg = 0.5F * static_cast<float>(tilt);
  return state;
}

Status KinectMotor::set_tilt(float tilt_deg) {
  // Beyond its range the motor stalls against the stop.
  if (!(tilt_deg >= -kTiltMax_deg && tilt_deg <= kTiltMax_deg))
    return Error{ErrorCode::invalid_argument, what_ + ": a tilt of " + std::to_string(tilt_deg) +
                                                  " degrees, expected -" + std::to_string(kTiltMax_deg) + " to " +
                                                  std::to_string(kTiltMax_deg)};
  const int half_degrees = static_cast<int>(2.0F * tilt_deg + (tilt_deg < 0 ? -0.5F : 0.5F));
  auto ok = transport_->control_out({kRequestOut, kMotorSetTilt, static_cast<std::uint16_t>(half_degrees), 0}, {},
                                    kTransfer_ms);
  if (!ok) return Error{ok.error().code, what_ + ": the motor does not take the tilt: " + ok.error().message};
  return Ok{};
}

std::optional<Vec3f> KinectMotor::down() {
  const auto now = state();
  if (!now || now->moving) return std::nullopt;
  const Vec3f up = now->acceleration_g;
  const float length_g = norm(up);
  if (!(length_g >= kRestMin_g && length_g <= kRestMax_g)) return std::nullopt;
  // Down is -up; x left and y up become x right and y down.
  return normalized(Vec3f{up.x, up.y, -up.z});
}

}  // namespace im2fit::hal
