// SPDX-License-Identifier: Apache-2.0
// A result.json read back: the body it describes.
#pragma once

#include <string>
#include <vector>

#include "body/model.h"
#include "core/status.h"
#include "person/tape_regression.h"

namespace im2fit {

struct MeasuredBody {
  body::Params params;
  float female = 0;                          // probability
  std::vector<float> tape_values;            // a value a definition of the shipped tape; not-a-number: none
  std::vector<TapeInterval> tape_intervals;  // as tape_values
};
// Errors name the file and the field. The mesh of `params` is that of the answer to some 0.1 mm: numbers are rounded.
Result<MeasuredBody> read_measured_body(const std::string& path, const body::BodyModel& model);

}  // namespace im2fit
