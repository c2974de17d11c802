// SPDX-License-Identifier: Apache-2.0
// Where a measurement runs, drawn on a body seen from the front and from its left.
#pragma once

#include <span>
#include <string>

#include "body/tape.h"
#include "report/canvas.h"

namespace im2fit {

struct TapePicture {
  Canvas canvas{1, 1};
  std::string svg;
};

// `mesh`: posed, as TapeMeasurer::mesh(). What the body hides is drawn pale.
TapePicture draw_tape(const body::BodyModel& model, std::span<const Vec3f> mesh, const body::TapeLines& lines,
                      const std::string& title);

}  // namespace im2fit
