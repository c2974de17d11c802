// SPDX-License-Identifier: Apache-2.0
// What is worked out of a measured body: volume, surface, ratios of girths, and body fat by a published equation. Not
// a medical device: nothing here diagnoses anything. The device library has none of it (report/full_result.h).
#pragma once

#include <optional>
#include <span>

#include "body/model.h"
#include "body/tape.h"
#include "core/floor_plane.h"
#include "core/joints.h"
#include "index/index.h"
#include "person/avatar.h"
#include "person/tape_regression.h"

namespace im2fit {

// Share of the weight, as the equation of the U.S. Navy gives it:
//   density = a - b log10(girths) + c log10(stature), centimetres; fat = 495 / density - 450
//   men    girths = abdomen at the navel - neck           a 1.0324   b 0.19077  c 0.15456   standard error 3.52
//   women  girths = narrowest waist + hip - neck          a 1.29579  b 0.35004  c 0.22100   standard error 3.72
// J. A. Hodgdon, M. B. Beckett, Naval Health Research Center, reports 84-11 (men) and 84-29 (women), 1984: sailors,
// weighed under water. The narrowest waist is that between navel and breastbone: natural_waist_girth of the tape.
struct NavyFat {
  bool woman = false;
  float standard_error = 0;         // of the equation, percent of the weight
  index::IntervalEstimate percent;  // of the equation and of the girths together
};
inline constexpr float kNavyErrorMen = 3.52F, kNavyErrorWomen = 3.72F;
// An equation for each sex: less sure of it, neither is used.
inline constexpr float kFatSexSure = 0.95F;

// Intervals, 95 %: errors of the measurements behind, taken as independent of each other. Errors of waist and hip go
// together (estimate/error_correlation.inc), so their ratio is surer than it says.
struct BodyFigures {
  index::IntervalEstimate volume_l;         // of the answered body's mesh: the weight's relative interval
  index::IntervalEstimate surface_area_m2;  // of its skin
  index::IntervalEstimate waist_to_hip, waist_to_height, body_mass_index;
  std::optional<NavyFat> fat;
};

// Errors of the surface of a body whose stature, weight and girths are right, as a share of it, two standard
// deviations: 0.032 of 16 people (tests/apps/figures_test.cpp).
inline constexpr double kSurfaceShapeShare = 0.035;

// `tape` with its values and intervals: of the same body; empty: no fat.
BodyFigures body_figures(const index::Answer& answer, const AnsweredBody& body, const body::BodyModel& model,
                         const body::Tape* tape, std::span<const float> tape_values,
                         std::span<const TapeInterval> tape_intervals);

// How much higher the own left shoulder joint stands than the right one, degrees of the line through both; of the
// joints behind an answer. None without a floor, or where a shoulder is not seen. The error: twice the standard
// deviation, 1.3 degrees of 24 rendered people (docs/result.md), and a third for their small number. Of the hips the
// error, 1.6, is larger than what people differ by, 1.1: they are left out.
inline constexpr float kShoulderTiltErrorDeg = 3.4F;
std::optional<index::IntervalEstimate> shoulder_tilt_deg(const JointSet& joints, const FloorPlane& floor);

// The closed mesh's, square metres.
double surface_area_m2(const body::BodyModel& model, std::span<const Vec3f> vertices);
// Of millimetres; girths as above. Not a number where the girths allow none.
double navy_fat_percent(bool woman, double girths_mm, double stature_mm);

}  // namespace im2fit
