// SPDX-License-Identifier: Apache-2.0
#include "perception/observe/sensor_traits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace im2fit {
namespace {

constexpr float kNearestM = 1.6F;  // no person is measured nearer; below 1.2 m the two kinds are alike

// Axial standard deviation in mm, z in m. Nguyen, Izadi, Lovell 2012, "Modeling Kinect sensor noise for improved 3D
// reconstruction and tracking", eq. 3; Fankhauser 2015, "Kinect v2 for mobile robot navigation: evaluation and
// modeling", with the base of train/camera/depth_sensor.h.
float kinect_noise_mm(float z) {
  return 1.2F + 1.9F * (z - 0.4F) * (z - 0.4F);
}
float tof_noise_mm(float z) {
  return 2.0F + 0.3F * z * z;
}
// The least of it that frames show.
float least_kinect_mm(float z) {
  return 0.5F * (kinect_noise_mm(z) + tof_noise_mm(z));
}
float least_tof_mm(float z) {
  return 0.8F * tof_noise_mm(z);
}

// 0 at `low`, 1 at `high`.
float ramp(float x, float low, float high) {
  return std::clamp((x - low) / (high - low), 0.0F, 1.0F);
}

// Of each kind, 1 in all.
struct Shares {
  float kinect = 0, tof = 0, silent = 0;
};

Shares shares_of(const SensorSigns& signs, float z) {
  const float loses = std::isnan(signs.lost) ? 0.0F : ramp(signs.lost, 0.03F, 0.08F);
  Shares s;
  if (std::isnan(signs.noise_mm)) {
    s.silent = 1;
  } else {
    const float towards_kinect = (signs.noise_mm - tof_noise_mm(z)) / (kinect_noise_mm(z) - tof_noise_mm(z));
    s.silent = ramp(signs.noise_mm, 2.0F, 1.0F);
    s.tof = std::max(1.0F - s.silent - ramp(towards_kinect, 0.15F, 0.45F), 0.0F);
  }
  s.tof += s.silent * loses;
  s.silent -= s.silent * loses;
  const float others = 1.0F - ramp(signs.one_sided, 0.10F, 0.16F);
  s.tof *= others;
  s.silent *= others;
  s.kinect = 1.0F - s.tof - s.silent;
  return s;
}

}  // namespace

std::array<float, kSensorTraits> sensor_traits(const SensorSigns& signs, float distance_mm, float focal_px,
                                               SensorKind kind) {
  const float pixel_mm = distance_mm / focal_px;
  if (signs.edges_restored) return {0, pixel_mm, 1, pixel_mm, 0, 0};
  const float z = std::max(distance_mm / 1000.0F, kNearestM);
  Shares s;
  if (kind == SensorKind::structured_light || kind == SensorKind::stereo) {
    s.kinect = 1;
  } else if (kind == SensorKind::time_of_flight) {
    s.tof = 1;
  } else if (std::isnan(signs.noise_mm) && std::isnan(signs.lost)) {
    constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
    return {kUnknown, pixel_mm, kUnknown, kUnknown, kUnknown, kUnknown};
  } else {
    s = shares_of(signs, z);
  }
  const float least_mm = s.kinect * least_kinect_mm(z) + s.tof * least_tof_mm(z);
  const float noise_mm = signs.noise_mm > least_mm ? signs.noise_mm : least_mm;  // not measured: the least
  return {noise_mm, pixel_mm, s.silent, s.silent * pixel_mm, s.tof, s.tof * pixel_mm};
}

}  // namespace im2fit
