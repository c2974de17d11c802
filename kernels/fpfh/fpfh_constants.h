// SPDX-License-Identifier: Apache-2.0
// Numbers of the pair arithmetic, the same in every tier.
#pragma once

namespace im2fit::fpfh_detail {

// The edges of f1's bins above zero: angles (2k + 1) pi / 11.
inline constexpr int kEdgeCount = 5;
inline constexpr float kEdgeCosine[kEdgeCount] = {0.959492974F, 0.654860734F, 0.142314838F, -0.415415013F,
                                                  -0.841253533F};
inline constexpr float kEdgeSine[kEdgeCount] = {0.281732557F, 0.755749574F, 0.989821442F, 0.909631995F, 0.540640817F};

// Where the cosines a1 and a2 differ by less than this, the swap is decided as PCL does; see swaps().
inline constexpr float kNearTie = 1e-6F;

// Below this 1 - a^2 the difference of squares has lost too many digits (float: 24 bits, 10 gone here).
inline constexpr float kNearlyParallel = 1e-3F;

}  // namespace im2fit::fpfh_detail
