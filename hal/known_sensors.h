// SPDX-License-Identifier: Apache-2.0
// How cameras sense depth, by the numbers they give themselves on USB.
#pragma once

#include <cstdint>

#include "core/sensor_kind.h"

namespace im2fit::hal {

// PrimeSense cameras, its products for other makers (Xtion, PS1080 and PS1200 boards), and the Kinect for Xbox 360
// and for Windows project patterns. Others are unknown here.
constexpr SensorKind sensor_of_usb(std::uint16_t vendor, std::uint16_t product) {
  constexpr std::uint16_t kPrimeSense = 0x1D27, kMicrosoft = 0x045E, kKinect = 0x02AE, kKinectForWindows = 0x02BF;
  const bool kinect = vendor == kMicrosoft && (product == kKinect || product == kKinectForWindows);
  return vendor == kPrimeSense || kinect ? SensorKind::structured_light : SensorKind::unknown;
}

}  // namespace im2fit::hal
