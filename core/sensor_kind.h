// SPDX-License-Identifier: Apache-2.0
// How a camera senses depth. Its effects on outlines depend on that (perception/observe/sensor_traits.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace im2fit {

enum class SensorKind : std::uint8_t {
  unknown,           // to be judged from the frames
  structured_light,  // Kinect for Xbox 360, Xtion, Astra: a projector beside the camera
  time_of_flight,    // Kinect v2, Azure Kinect
  stereo,            // RealSense D400, OAK-D: two cameras beside each other
};

// As command lines and results spell them, in the enum's order.
inline constexpr std::array<std::string_view, 4> kSensorKindNames = {"auto", "structured-light", "time-of-flight",
                                                                     "stereo"};
constexpr std::string_view name_of(SensorKind kind) {
  return kSensorKindNames[static_cast<std::size_t>(kind)];
}

}  // namespace im2fit
