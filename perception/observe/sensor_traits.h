// SPDX-License-Identifier: Apache-2.0
// What kind of depth sensor frames are from. Outlines depend on it: beside a person a Kinect's pixels stray and its
// projector throws a shadow, a time-of-flight sensor's mix person and wall and are lost, a sensor without noise has
// neither; widths differ by a pixel a side.
#pragma once

#include <array>
#include <cstddef>

#include "core/sensor_kind.h"

namespace im2fit {

inline constexpr std::size_t kSensorTraits = 6;

// What frames show of their sensor.
struct SensorSigns {
  float noise_mm = 0;           // standard deviation of a frame's pixel (TemporalNoise); NaN: not measured
  float lost = 0;               // share of the pixels beside the outline (OutlineLosses); NaN: not measured
  float one_sided = 0;          // of that share, more on one side than on the other; 0 where not measured
  bool edges_restored = false;  // outlines are as sharp as those of a sensor without noise (EdgeRestorer)
};

// `distance_mm` of the person, above 0; `focal_px` of the camera. In order:
//   noise, mm, at least what the kind shows at this distance: a driver that smooths over time hides it
//   a pixel's width at the person, mm
//   1 for a sensor without noise; that times the pixel's width
//   1 for time of flight; that times the pixel's width
// Those two and a Kinect share out one. A kind that is known is taken at its word. Stereo counts as a Kinect, the
// nearest kind that models have learned: both measure disparity, so noise grows with the square of the distance, and
// both lose a strip on one side of a person, which one of two views does not see. Else
//   a sensor that loses more pixels on one side (0.10 to 0.16) projects patterns: a Kinect;
//   without noise is a sensor that shows none (up to 1 mm, falling to 0 at 2) and loses none (3 to 8 in 100);
//   a Kinect and time of flight differ in where the noise lies between the published figures of both: a Kinect 0.5
//   to 0.8 of the distance; 0.45 counts as one, 0.15 as none, the weight rises between. A sensor that loses pixels
//   and shows no noise is time of flight.
// Restored edges are a noiseless sensor's, whatever else is seen or known.
// Before a wall a Kinect loses 0.12 to 0.45 of those pixels, one side 0.13 to 0.47 more; time of flight 0.10 to 0.25
// and 0.09 at most; a sensor without noise 0.02 at most (100 people each of im2fit-lab eval at 640x480, printed by an
// unpublished experiment). Neither noise nor losses measured: NaN but for the width.
std::array<float, kSensorTraits> sensor_traits(const SensorSigns& signs, float distance_mm, float focal_px,
                                               SensorKind kind = SensorKind::unknown);

}  // namespace im2fit
