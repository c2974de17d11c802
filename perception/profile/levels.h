// SPDX-License-Identifier: Apache-2.0
// Rows of trunk, legs and head accumulated into levels at fixed parts of the stature.
#pragma once

#include "perception/profile/profile.h"
#include "perception/profile/row_scan.h"

namespace im2fit::profile {

// Adds a row's values to the levels it lies between, in every band it belongs to.
void add_row(const Scene& s, const Row& row, ProfileWorkspace& work);
inline constexpr int kLevelFloats = ProfileLayout::kArms;  // trunk, legs and head lie before the arms in the layout

}  // namespace im2fit::profile
