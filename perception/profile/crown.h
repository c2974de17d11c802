// SPDX-License-Identifier: Apache-2.0
// Where the person ends above and below: heights at which the outline encloses given areas. A single topmost pixel
// is noise; some hundred square millimetres are a crown.
#pragma once

#include <span>

#include "perception/profile/profile.h"
#include "perception/profile/row_scan.h"

namespace im2fit::profile {

// Heights above the floor. Where no floor is known, sets the frame so that the lowest point is the zero of heights.
// Reads the workspace's outline and its tables of heights and sides. Leaves crown and soles as they are where the
// head is nowhere.
void crown_and_soles(Scene& s, bool floor_known, ProfileWorkspace& work, std::span<float> crown,
                     std::span<float> soles);

}  // namespace im2fit::profile
