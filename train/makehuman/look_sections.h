// SPDX-License-Identifier: Apache-2.0
// The sections look_* of a body file: what only pictures show. Nothing that is measured depends on them.
#pragma once

#include <span>

#include "core/container.h"
#include "core/status.h"
#include "train/makehuman/segments.h"
#include "train/makehuman/source.h"

namespace im2fit::body::makehuman {

struct LookInput {
  const Source& source;
  std::span<const int> new_index;                   // of each source vertex in the file, or -1
  std::span<const SegmentWeights> segment_weights;  // of each source vertex
  int texture_side;                                 // pixels
};
// Errors: the base mesh has no texture coordinates, or none is free for the eyes; the rig has no eyes.
Status add_look(const LookInput& input, ContainerWriter& writer);

}  // namespace im2fit::body::makehuman
