// SPDX-License-Identifier: Apache-2.0
// Fast point feature histograms (Rusu 2009) with PCL 1.13's exact semantics (docs: facts in kernels/fpfh/README.md).
// Tiers: ref (double, readable), portable (float32, the contract), neon and avx2 (portable's bits).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/lazy_zeros.h"
#include "kernels/tier.h"

namespace im2fit {

inline constexpr int kFpfhBins = 11;  // per group
inline constexpr int kFpfhSize = 3 * kFpfhBins;
inline constexpr float kFpfhRadiusMm = 200.0F;

// Points and normals of an organised image, structure of arrays, width*height values each. A missing point has
// NaN in x, y and z; a missing normal has NaN in nx, ny and nz. Point (u, v) must project near pixel (u, v) of
// `intrinsics` (within half a pixel), because that limits the neighbour search. Points have z > 0.
struct OrganisedCloud {
  Intrinsics intrinsics;
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;  // mm
  const float* nx = nullptr;
  const float* ny = nullptr;
  const float* nz = nullptr;  // unit
};

// Buffers sized once for images up to width x height. Contents are the kernels' own. 200 bytes a pixel, of which only
// the part that points need becomes resident.
class FpfhWorkspace {
 public:
  FpfhWorkspace(int width, int height);

  // Compacted valid points in row order; metres, because PCL's float rounding at the radius is in metres.
  LazyZeros<float> x, y, z, nx, ny, nz;
  LazyZeros<std::int32_t> row_table;            // (width + 1) per row: first compact point at or right of a column
  LazyZeros<std::uint8_t> has_normal;           // per compact point
  LazyZeros<std::uint8_t> needed;               // per compact point: a keypoint wants its SPFH
  std::unique_ptr<std::int32_t[]> counts;       // kFpfhSize per compact point
  std::unique_ptr<std::uint8_t[]> count_bytes;  // the hand-written tiers' (fpfh_blocks.h), not yet in `counts`
  std::vector<float> row_slope, row_norm, row_inverse_norm;  // y/z of a row's rays, sqrt(1 + slope^2), its inverse
  std::vector<std::int32_t> columns_low, columns_high;       // a sphere's outline, by row
  std::vector<std::int32_t> ranges;                          // begin and end of a source's candidates
  LazyZeros<std::int32_t> near_list;                         // neighbours with a normal
  LazyZeros<std::int32_t> blank_list;                        // neighbours without one
};

// Descriptors of `keypoints` (any positions in mm, not necessarily cloud points): out has 33 values each, three
// groups of 11 scaled to 100; all zero where nothing is in range or the keypoint is not finite. SPFHs are shared
// between keypoints. No allocation except in ref; no threads; a workspace serves one call at a time.
using FpfhFunction = void(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                          FpfhWorkspace& work, std::span<float> out);
void fpfh_portable(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                   FpfhWorkspace& work, std::span<float> out);
FpfhFunction fpfh_neon, fpfh_avx2;
// The best tier of this machine.
void fpfh(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
          std::span<float> out);

using FpfhKernel = KernelVariant<FpfhFunction>;
inline constexpr FpfhKernel kFpfhKernels[] = {IM2FIT_PORTABLE(fpfh) IM2FIT_NEON(fpfh) IM2FIT_AVX2(fpfh)};

}  // namespace im2fit
