// SPDX-License-Identifier: Apache-2.0
// What depth_sensor.cpp and depth_sensor_frame.cpp both know.
#pragma once

#include "train/camera/depth_sensor.h"

namespace im2fit::lab {

// 1/z = (7.5 - m)/9000, m = ((raw - 800)/4 - 0.375) 0.1042: the formula of the device's own driver.
inline constexpr double kRawAtInfinity = 7.5 / 0.1042 * 4 + 800 + 1.5;
inline constexpr float kRawPerInverseMm = static_cast<float>(1 / kRawStepPerMm);
inline constexpr float kDepthStep = 0.02F;  // relative: a jump of 40 mm at 2 m is an edge
inline constexpr int kEdgeReachPx = 2;

}  // namespace im2fit::lab
