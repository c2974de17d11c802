// SPDX-License-Identifier: Apache-2.0
// The one table of measurement ids: result JSON, C header, index, evaluation and docs all use it.
// Of the naked body, relaxed standing; girths on the convex hull of the section. body/measure.cpp takes each.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace im2fit {

enum class Measurement : int {
  stature,
  sleeve_length,
  leg_length,
  shoulder_breadth,
  neck_girth,
  shoulder_girth,
  chest_girth,
  waist_girth,
  hip_girth,
  inside_leg,
  weight,
};
inline constexpr std::size_t kMeasurementCount = 11;

struct MeasurementInfo {
  std::string_view id;
  std::string_view unit;  // "mm" or "kg"
  std::string_view iso;   // ISO 8559-1:2017 number, "" where there is none
};
inline constexpr std::array<MeasurementInfo, kMeasurementCount> kMeasurementTable = {{
    {"stature", "mm", "5.1.1"},
    {"sleeve_length", "mm", "5.7.8"},
    {"leg_length", "mm", ""},
    {"shoulder_breadth", "mm", ""},
    {"neck_girth", "mm", "5.3.2"},
    {"shoulder_girth", "mm", ""},
    {"chest_girth", "mm", "5.3.4"},
    {"waist_girth", "mm", "5.3.10"},
    {"hip_girth", "mm", "5.3.13"},
    {"inside_leg", "mm", "5.1.15"},
    {"weight", "kg", ""},
}};
constexpr std::size_t measurement_index(Measurement m) {
  return static_cast<std::size_t>(m);
}

// Values in the table's order and units.
using MeasurementValues = std::array<float, kMeasurementCount>;

}  // namespace im2fit
