// SPDX-License-Identifier: Apache-2.0
// The local modifiers we pack, and what each layout calls their targets.
#pragma once

#include <string>
#include <vector>

#include "train/makehuman/source.h"

namespace im2fit::body::makehuman {

struct Modifier {
  std::string name;              // "torso/torso-vshape"
  std::vector<TargetName> low;   // moved by negative values; two for a joined left-right pair
  std::vector<TargetName> high;  // moved by positive values
};

// Joined pairs come as "armslegs/upperleg-fat", then "armslegs/l-upperleg-fat" and "armslegs/r-upperleg-fat".
std::vector<Modifier> modifier_table();

}  // namespace im2fit::body::makehuman
