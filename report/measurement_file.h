// SPDX-License-Identifier: Apache-2.0
// The tape of a measured person as files of pattern makers' programs (docs/tape.md).
#pragma once

#include <string>

#include "core/status.h"
#include "person/person_measurement.h"

namespace im2fit {

enum class LengthUnit { mm, cm, in };

// Whether a path has the ending of a measurement file; else what is wrong with it. "" when it is one.
std::string measurement_file_fault(const std::string& path);

// By the ending of `path`:
//   .smis   Seamly2D, cm unless inches are wanted
//   .json   FreeSewing, mm always
//   .yaml   GarmentCode, cm always. What is not measured there is that of its mean body, scaled, and marked
//   .csv    all of the tape with intervals, in `unit`
// Error: invalid_argument (another ending), unsupported (nothing was measured).
Result<std::string> measurement_file(const PersonMeasurement& person, const std::string& path, LengthUnit unit);

}  // namespace im2fit
