// SPDX-License-Identifier: Apache-2.0
// Fast point feature histograms (Rusu 2009) with PCL 1.13's exact semantics (docs: facts in kernels/fpfh/README.md).
// Tiers: ref (double, readable) and portable (float32, the contract); further tiers register in kernels.inc.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kernels/core/camera.h"

namespace im2fit {

inline constexpr int kFpfhSize = 33;
inline constexpr float kFpfhRadiusMm = 200.0F;

// Points and normals of an organised image, structure of arrays, width*height values each. A missing point has
// NaN in x, y and z; a missing normal has NaN in nx, ny and nz. Point (u, v) must project near pixel (u, v) of
// `intrinsics` (within half a pixel): that is what limits the neighbour search.
struct OrganisedCloud {
  Intrinsics intrinsics;
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;   // mm
  const float* nx = nullptr;
  const float* ny = nullptr;
  const float* nz = nullptr;  // unit
};

// Buffers sized once for images up to width x height.
class FpfhWorkspace {
 public:
  FpfhWorkspace(int width, int height);
  std::vector<std::int32_t> compact_index;  // pixel -> compact point
  std::vector<std::int32_t> row_begin;
  std::vector<std::int32_t> column;
  std::vector<float> x, y, z, nx, ny, nz;   // compacted valid points, row order
  std::vector<float> spfh;                  // 33 per compact point
  std::vector<std::uint8_t> spfh_state;     // 0 = not computed
};

// Descriptors of `keypoints` (any positions, not necessarily cloud points): out has 33 values each, three groups of
// 11 scaled to 100; all zero where nothing is in range. SPFHs are shared between keypoints.
void fpfh_ref(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
              std::span<float> out);
void fpfh_portable(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm,
                   FpfhWorkspace& work, std::span<float> out);
// The best tier of this machine.
void fpfh(const OrganisedCloud& cloud, std::span<const Vec3f> keypoints, float radius_mm, FpfhWorkspace& work,
          std::span<float> out);

}  // namespace im2fit
