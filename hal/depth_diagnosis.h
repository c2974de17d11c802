// SPDX-License-Identifier: Apache-2.0
// Whether a picture can be a room in millimetres, for people whose frames show no person: most of them have another
// unit, another byte order or a camera on its side.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>

#include "core/camera.h"

namespace im2fit::hal {

enum class DiagnosisCode : int {
  none,
  little_depth,
  raw_disparity,  // a Kinect's, 11 bits
  bytes_swapped,
  player_bits,      // three bits below the depth
  confidence_bits,  // three bits above it
  float_values,     // 32-bit floating point read as 16-bit integers
  no_depth_picture,
  unit,
  rotated,
  centre,         // the intrinsics' centre is that of the other orientation
  field_of_view,  // of the intrinsics
};
inline constexpr std::array<std::string_view, 12> kDiagnosisNames = {"",
                                                                     "LITTLE_DEPTH",
                                                                     "RAW_DISPARITY",
                                                                     "BYTES_SWAPPED",
                                                                     "PLAYER_BITS",
                                                                     "CONFIDENCE_BITS",
                                                                     "FLOAT_VALUES",
                                                                     "NO_DEPTH_PICTURE",
                                                                     "UNIT",
                                                                     "ROTATED",
                                                                     "CENTRE",
                                                                     "FIELD_OF_VIEW"};
constexpr std::string_view name_of(DiagnosisCode code) {
  return kDiagnosisNames[static_cast<std::size_t>(code)];
}

struct DepthDiagnosis {
  DiagnosisCode code = DiagnosisCode::none;
  float unit_mm = 0;   // of `unit` and `player_bits`: what --unit makes right; 0: not known
  int rotate_deg = 0;  // of `rotated`
  std::string text;    // a description and the remedy, as part of a sentence; "" for none
};

// How well a picture of this unit would be measured, 0: not at all, 1: best. Values that make a room as they are keep
// their unit unless a better one has 0.5 and more. Of several units that make a room the best is
// named; of none that is better, the one in which the middle of the picture is 2.7 m away.
using UnitJudge = std::function<float(float unit_mm)>;

// It reads one pixel in 8 at most, and allocates; not for every frame.
DepthDiagnosis depth_diagnosis(DepthView depth, const UnitJudge& judge = nullptr);
// Of pixels that were read in this unit: what --unit must be in its place.
DepthDiagnosis read_in_unit(DepthDiagnosis diagnosis, double unit_mm);
// Of the intrinsics of an upright picture: none, centre or field_of_view.
DepthDiagnosis intrinsics_diagnosis(const Intrinsics& intrinsics);

}  // namespace im2fit::hal
