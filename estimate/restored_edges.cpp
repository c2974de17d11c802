// SPDX-License-Identifier: Apache-2.0
#include "estimate/restored_edges.h"

#include <algorithm>

namespace im2fit {
namespace {

// A pixel of 256 across at 3.6 m, where people are refused for being far.
constexpr double kPixelMostMm = 16;

// `offset`: of the value, a mm of pixel; mm, and kg of the weight. `width`: of the interval.
struct Row {
  double offset, width;
};

// Offsets are the mean difference of answers to the same people, rooms and noise by a Kinect of 256x192 pixels and by
// the two kinds of phone (`im2fit-lab eval --family ansur,modifiers --seed 777 --conditions
// 256,phone-smooth,phone-tof`, 200 people a family, both families alike; by the pixel's 10.4 mm); the truth has no
// part in them. Widths are what the truth then needs for 95.5 % of the sessions of 70 people of ansur, and a tenth
// more for drivers that are neither; never less than 1.1. Leg lengths are as far off for a Kinect.
// docs/notebook/phones.md.
constexpr std::array<Row, kMeasurementCount> kRows = {{
    {0.30, 1.1},   // stature
    {1.13, 1.25},  // sleeve length
    {-0.28, 1.1},  // leg length
    {0.17, 1.1},   // shoulder breadth
    {1.10, 1.1},   // neck girth
    {0.92, 1.25},  // shoulder girth
    {1.70, 1.1},   // chest girth
    {2.20, 1.1},   // waist girth
    {1.41, 1.1},   // hip girth
    {0.21, 1.3},   // inside leg
    {0.068, 1.1},  // weight
}};

}  // namespace

SiteCorrection restored_edges_correction(float pixel_mm) {
  const double pixel = std::clamp(static_cast<double>(pixel_mm), 0.0, kPixelMostMm);
  SiteCorrection correction;
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const double offset = kRows[m].offset * pixel;
    correction.rows[m] = {1, offset, offset, kRows[m].width};
  }
  return correction;
}

}  // namespace im2fit
