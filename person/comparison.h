// SPDX-License-Identifier: Apache-2.0
// Two captures of one person: what has changed, and what only the camera says. docs/compare.md.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/measurement.h"
#include "core/status.h"
#include "index/index.h"

namespace im2fit {

// What of a result.json a comparison needs. Texts are "" where the file has none.
struct Capture {
  std::string path;
  std::array<index::IntervalEstimate, kMeasurementCount> measurements{};  // not a number: none
  std::string views;                                                      // "front", "front+back", "around"
  std::string answered_as;                                                // "bare", "dressed"
  bool looks_dressed = false;                                             // by the frames alone
  std::string program, index;                                             // that made it: version and digest
  std::string site;                                                       // its calibration; "": none
  std::string known;  // the facts that the answer rests on, as JSON; "": none
};
// `path`: a result.json, or a folder that holds one (a session, the --out of a measurement). Errors: as read_json;
// unsupported for another schema, invalid_argument where nobody was measured; corrupt, naming the field.
Result<Capture> read_capture(const std::string& path);

struct MeasureChange {
  Measurement measurement = Measurement::stature;
  float before = 0, after = 0;     // not a number: none
  float difference = 0, half = 0;  // after less before, and the half width of its interval
  bool changed() const { return difference > half || difference < -half; }
};
struct Comparison {
  // Why the interval of a difference takes the errors of both captures as independent of each other; empty: it
  // rests on how captures of one person repeat.
  std::vector<std::string> wider;
  bool two_people = false;  // the statures differ by more than both intervals allow
  std::array<MeasureChange, kMeasurementCount> changes{};
};
Comparison compare(const Capture& before, const Capture& after);

// To either side of a 95 % interval: of eleven measurements of an unchanged person one in twenty is called changed.
inline constexpr double kComparisonSds = 1.96;
// Technical error of measurement of captures in new poses, rooms and noise, by views; 0: not known.
double repeat_error(Measurement measurement, const std::string& views);

}  // namespace im2fit
