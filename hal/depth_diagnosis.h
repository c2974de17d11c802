// SPDX-License-Identifier: Apache-2.0
// Whether a picture can be a room in millimetres, for people whose frames show no person: most of them have another
// unit, another byte order or a camera on its side.
#pragma once

#include <string>

#include "core/camera.h"

namespace im2fit::hal {

// "" for a plausible depth picture, else a description of its values and the remedy, as part of a sentence. It reads
// one pixel in 16 at most, and allocates; not for every frame.
std::string depth_diagnosis(DepthView depth);

}  // namespace im2fit::hal
