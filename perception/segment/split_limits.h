// SPDX-License-Identifier: Apache-2.0
// The constants of split.cpp: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception-thresholds.md. Sources:
//   [touch] people who touch with their heads out of the picture (commit 3dafe52, tried on 250 furnished,
//           dressed scenes); no measurement of these on record
#pragma once

namespace im2fit::segment::split_limits {

inline constexpr float kSeenNearMm = 400.0F;  // from an expected head to one seen: they are the same; [touch]
inline constexpr float kUnderMm = 160.0F;     // either side of the line below a crown: half a trunk's width; [touch]
inline constexpr float kUnderAreaMinM2 = 0.1F;  // surface there, least; [touch]
inline constexpr float kDepthWeight = 0.7F;     // distance in depth, in units of that sideways; [touch]

}  // namespace im2fit::segment::split_limits
