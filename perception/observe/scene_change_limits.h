// SPDX-License-Identifier: Apache-2.0
// The constants of scene_change.cpp.
#pragma once

namespace im2fit::scene_change_limits {

// Along the long side, as many pixels are looked at: every eighth of 640, a finger's breadth apart at 1 m, 55 mm at 4
// m.
inline constexpr int kLookedAtLong = 80;
// Pixels looked at in a block, a side: at 4 m a block is 220 mm wide, the breadth of a head or of two limbs.
inline constexpr int kBlockSide = 4;
inline constexpr int kChangedMin = kBlockSide * kBlockSide / 2;
// A Kinect's depth scatters by 1.4e-6 z^2 (SD in mm, z in mm; Khoshelham and Elberink 2012): the difference of two
// pictures stays within five of its SD, and within the few centimetres by which a person sways.
inline constexpr int kToleranceMm = 60;
inline constexpr int kToleranceDivisor = 100'000;  // of z^2: 22 mm at 1.5 m, 160 mm at 4 m

}  // namespace im2fit::scene_change_limits
