// SPDX-License-Identifier: Apache-2.0
#include "engine/restored_edges.h"

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
// the two kinds of phone (`im2fit-lab eval --family ansur --seed 777 --conditions 256,phone-smooth,phone-tof`, 70
// people, index of 8,000; by the pixel's 10.4 mm); the truth has no part in them. Widths are what the truth then
// needs for 95.5 % of the 140 sessions, and a tenth more for drivers that are neither; never less than 1.1. Leg
// lengths are as far off for a Kinect. docs/notebook/phones.md.
constexpr std::array<Row, kMeasurementCount> kRows = {{
    {0.43, 1.1},   // stature
    {0.69, 1.25},  // sleeve length
    {-0.41, 1.1},  // leg length
    {0.05, 1.1},   // shoulder breadth
    {1.49, 1.1},   // neck girth
    {1.17, 1.25},  // shoulder girth
    {2.42, 1.1},   // chest girth
    {1.79, 1.1},   // waist girth
    {1.19, 1.1},   // hip girth
    {0.24, 1.3},   // inside leg
    {0.085, 1.1},  // weight
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
