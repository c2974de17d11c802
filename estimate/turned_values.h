// SPDX-License-Identifier: Apache-2.0
// What a tape reads of a body that was seen from all round: the measurements of its mesh, with the chest and the hip
// taken where a surface shows them best.
#pragma once

#include <span>

#include "body/measure.h"
#include "body/model.h"
#include "core/measurement.h"

namespace im2fit {

struct TurnedValues {
  MeasurementValues values{};     // mm, kg; NaN: no section
  body::Measurer::Slopes slopes;  // of the girths over height, in the relaxed pose
};

// `rest_vertices`: all of the model's, mm. No allocation. Leaves the arms of measurer.posed() off the body.
TurnedValues measure_turned(const body::BodyModel& model, body::Measurer& measurer,
                            std::span<const Vec3f> rest_vertices, bool woman);

}  // namespace im2fit
