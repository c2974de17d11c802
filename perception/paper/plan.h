// SPDX-License-Identifier: Apache-2.0
// What is measured where: the definitions both tiers share, in the paper's names.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/fixed.h"
#include "perception/paper/paper.h"

namespace im2fit::paper_detail {

// The paper's epsilons are all 1/10: |cosine| < 1/10 is tested as 100 dot^2 < length^2 (sections: kernels/section).
inline constexpr int kEpsilonInverseSquared = 100;

// A section is walked across in bins of 8 mm from its centre outwards and ends where the next point is further away
// sideways than a hole in the depth may be, or jumps in depth: there the arm begins.
inline constexpr int kBinMm = 8;
inline constexpr int kSectionHalfMm = 512;  // further from the centre than any trunk reaches; a section's own bound
static_assert(kSectionHalfMm << SectionMm::kFractionBits == kSectionCoordinateMax + 1);
inline constexpr int kStartReachMm = 40;  // the centre joint may lie beside a hole
inline constexpr int kHoleMm = 24;        // and never less than 2.5 pixels
inline constexpr int kJumpMm = 60;        // an ellipse of 170 x 115 mm falls by 35 mm over its last bin
inline constexpr double kHolePixels = 2.5;

// Eq. (4), with the paper's indices.
inline std::array<Vec3f, kPaperSectionCount> section_centres(const JointSet& j) {
  const Vec3f neck = (j[Joint::NE] + j[Joint::HE]) * 0.5F;
  const Vec3f shoulder = (neck + (j[Joint::LS] + j[Joint::RS]) * 0.5F) * 0.5F;
  return {neck, shoulder, (j[Joint::NE] + j[Joint::TO]) * 0.5F, j[Joint::TO], (j[Joint::LH] + j[Joint::RH]) * 0.5F};
}

// How many bins sideways a hole may span at this depth.
inline int hole_bins(float z_mm, float fx) {
  const double pixel_mm = double{z_mm} / double{fx};
  const double hole = kHolePixels * pixel_mm > kHoleMm ? kHolePixels * pixel_mm : kHoleMm;
  const int bins = static_cast<int>(hole / kBinMm) + 1;
  return bins < PaperWorkspace::kBinCount ? bins : PaperWorkspace::kBinCount;
}

inline constexpr int kUnitsPerBin = kBinMm << SectionMm::kFractionBits;
inline constexpr int kFirstUnit = -(kSectionCoordinateMax + 1);  // where bin 0 begins

struct BinRange {
  int first = 0, last = -1;  // inclusive; empty where the section has no start
};

// The connected run of bins about the centre. count(b) and mean_depth(b) in mm describe bin b.
template <class Count, class MeanDepth>
BinRange connected_bins(int hole, Count count, MeanDepth mean_depth) {
  constexpr int kBins = PaperWorkspace::kBinCount;
  int start = -1;
  for (int step = 0; step < kStartReachMm / kBinMm && start < 0; ++step) {
    if (count(kBins / 2 + step) > 0)
      start = kBins / 2 + step;
    else if (count(kBins / 2 - 1 - step) > 0)
      start = kBins / 2 - 1 - step;
  }
  if (start < 0) return {};
  const auto walk = [&](int direction) {
    int at = start;
    for (int b = start + direction; b >= 0 && b < kBins && (b - at) * direction <= hole; b += direction) {
      if (count(b) == 0) continue;
      if (std::fabs(mean_depth(b) - mean_depth(at)) > kJumpMm * ((b - at) * direction)) break;
      at = b;
    }
    return at;
  };
  return {walk(-1), walk(+1)};
}

// Finite and within 30 m: squares of differences then fit 64 bits with room to spare.
inline bool usable_joints(const JointSet& joints) {
  constexpr float kFarthestMm = 30000.0F;
  for (const Vec3f& p : joints.position_mm) {
    for (const float coordinate : {p.x, p.y, p.z}) {
      if (!(std::fabs(coordinate) < kFarthestMm)) return false;
    }
  }
  return true;
}

using GeodesicMm = Fixed<std::int32_t, 7>;

// The length of the polyline through `count` points, in 1/128 mm: the sum of its steps' lengths, each rounded to the
// nearest 1/128 mm. x, y, z: GeodesicMm raws within +-2^30; the parts of a step saturate at +-256 mm (a surface seen
// that coarsely is another one): the sum of their squares is at most 3 * 2^30, its root 56756, so 75,000 steps fit
// the result. Roots are rounded to the nearest, not down: the errors cancel. 0 for fewer than two points. Integers;
// no allocation, thread-safe.
std::uint32_t geodesic(const std::int32_t* x, const std::int32_t* y, const std::int32_t* z, int count);

// Length of the surface between the points seen at LS and RS over their distance: see surface_ratio.cpp. NaN where
// too little of it is seen.
float surface_ratio(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                    const JointSet& joints);

// Fills what follows from the five girths, in the order of section_centres (NaN: no ellipse).
void set_girths(const std::array<float, kPaperSectionCount>& girths_mm, PaperMeasurements& m);
// All lengths NaN, not valid.
PaperMeasurements unmeasured();

}  // namespace im2fit::paper_detail
