// SPDX-License-Identifier: Apache-2.0
// What kind of depth sensor frames are from. Outlines depend on it: beside a person a Kinect's pixels stray and its
// projector throws a shadow, a time-of-flight sensor's mix person and wall and are lost, a sensor without noise has
// neither; widths differ by a pixel a side.
#pragma once

#include <array>
#include <cstddef>

#include "kernels/core/sensor_kind.h"

namespace im2fit {

inline constexpr std::size_t kSensorTraits = 6;

// `noise_mm`: standard deviation of a frame's pixel (TemporalNoise), NaN where it is not measured. `distance_mm` of
// the person, above 0; `focal_px` of the camera. In order:
//   noise, mm
//   a pixel's width at the person, mm
//   1 for a sensor without noise, falling to 0 from 1 to 2 mm of it; that times the pixel's width
//   1 for time of flight: what is left when the other two kinds are taken from 1; that times the pixel's width
// A kind that is known is taken at its word: a driver that smooths over time hides the noise, and what a sensor does
// to outlines stays. Noise is then at least what the kind shows at this distance. One that is not known is told by
// how noisy frames are, Kinect from time of flight by where between what is published of both: a Kinect's is 0.5 to
// 0.8 of the way, of which 0.45 are asked for and from 0.15 on some believed. Unknown and not measured: NaN but for
// the width.
std::array<float, kSensorTraits> sensor_traits(float noise_mm, float distance_mm, float focal_px,
                                               SensorKind kind = SensorKind::unknown);

}  // namespace im2fit
