// SPDX-License-Identifier: Apache-2.0
#include "kernels/observe/sensor_traits.h"

#include <algorithm>

namespace im2fit {
namespace {

constexpr float kNearestM = 1.6F;  // nobody is measured nearer; below 1.2 m the two kinds are alike

// Axial standard deviation in mm, z in m. Nguyen, Izadi, Lovell 2012, "Modeling Kinect sensor noise for improved 3D
// reconstruction and tracking", eq. 3; Fankhauser 2015, "Kinect v2 for mobile robot navigation: evaluation and
// modeling", with the base of synth/depth_sensor.h.
float kinect_noise_mm(float z) {
  return 1.2F + 1.9F * (z - 0.4F) * (z - 0.4F);
}
float tof_noise_mm(float z) {
  return 2.0F + 0.3F * z * z;
}

// 0 at `low`, 1 at `high`.
float ramp(float x, float low, float high) {
  return std::clamp((x - low) / (high - low), 0.0F, 1.0F);
}

}  // namespace

// The least of what frames of this kind show of its published noise, mm.
float least_noise_mm(SensorKind kind, float z) {
  constexpr float kKinectWay = 0.5F, kTofShare = 0.8F;
  const float tof = tof_noise_mm(z);
  return kind == SensorKind::time_of_flight ? kTofShare * tof : tof + kKinectWay * (kinect_noise_mm(z) - tof);
}

std::array<float, kSensorTraits> sensor_traits(float noise_mm, float distance_mm, float focal_px, SensorKind kind) {
  const float pixel_mm = distance_mm / focal_px;
  const float z = std::max(distance_mm / 1000.0F, kNearestM);
  if (kind != SensorKind::unknown) {
    const float tof = kind == SensorKind::time_of_flight ? 1.0F : 0.0F;
    const float least = least_noise_mm(kind, z);
    return {noise_mm > least ? noise_mm : least, pixel_mm, 0, 0, tof, tof * pixel_mm};  // NaN is not above it
  }
  const float silent = ramp(noise_mm, 2.0F, 1.0F);
  const float way = (noise_mm - tof_noise_mm(z)) / (kinect_noise_mm(z) - tof_noise_mm(z));
  const float tof = std::max(1.0F - silent - ramp(way, 0.15F, 0.45F), 0.0F);
  return {noise_mm, pixel_mm, silent, silent * pixel_mm, tof, tof * pixel_mm};
}

}  // namespace im2fit
