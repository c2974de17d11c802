// SPDX-License-Identifier: Apache-2.0
// MakeHuman's 163 bones as our 19 segments: where they turn, and what moves with them.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "body/model_data.h"
#include "train/makehuman/source.h"

namespace im2fit::body::makehuman {

inline constexpr int kCubeSize = 8;  // vertices of a joint cube

constexpr std::size_t index_of(Segment s) {
  return static_cast<std::size_t>(s);
}
constexpr std::size_t index_of(int v) {
  return static_cast<std::size_t>(v);
}

// Joints as "bone:head" / "bone:tail"; several are joined with '+'.
extern const std::array<std::string_view, kSegmentCount> kSegmentHeads;
extern const std::array<std::string_view, kSegmentCount> kSegmentTails;
extern const std::array<std::string_view, kJointCount> kOpenNiJoints;

// The source vertices whose mean such a joint is (joined ones are of equal size, so the mean is the mean of means).
Result<std::vector<int>> joint_vertices(const Rig& rig, std::string_view joint);

using SegmentWeights = std::array<double, kSegmentCount>;

// Per source vertex, sums as in the data; joint cubes belong to one segment.
Result<std::vector<SegmentWeights>> segment_weights(const Source& source);

// Sums run from .32 to 1.67 in the data: normalised. A vertex without weights (ground) stays with the pelvis.
SkinRecord heaviest_four(const SegmentWeights& weights);

}  // namespace im2fit::body::makehuman
