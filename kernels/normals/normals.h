// SPDX-License-Identifier: Apache-2.0
// Normals of an organised cloud: the plane through each point's window in the total least squares sense.
#pragma once

#include "core/camera.h"
#include "kernels/tier.h"

namespace im2fit {

// Of `intrinsics` only width and height count; the camera is the origin. x, y, z: width*height values in mm, NaN in
// all three where there is no point. For each point, the points of its (2 radius_px + 1)^2 window (cut at the border)
// whose z is within max_step_mm of its own are fitted by the plane through their mean along which their covariance is
// least (the eigenvector of its smallest eigenvalue). nx, ny, nz: unit, towards the camera (n.p <= 0), NaN in all
// three where there is no point, fewer than half of the window is usable, or the usable points lie on a line.
// radius_px >= 1. No allocation, thread-safe. Portable differs from ref by at most 1e-3 rad where the smallest
// eigenvalue is below half of the next (float covariance, 2^-32 left of the other eigenvectors).
using NormalsFunction = void(const Intrinsics& intrinsics, const float* x, const float* y, const float* z,
                             int radius_px, float max_step_mm, float* nx, float* ny, float* nz);
// neon and avx2 give portable's bits. ARMv7 has no neon variant: its vectors can neither divide nor take roots, and
// a normal needs thirteen of these operations.
NormalsFunction normals_portable, normals_neon, normals_avx2;
// The best tier of this machine.
NormalsFunction normals;

// Points on a line: second eigenvalue below about this share of the largest.
inline constexpr float kNormalsLineShare = 1e-3F;

using NormalsKernel = KernelVariant<NormalsFunction>;
inline constexpr NormalsKernel kNormalsKernels[] = {IM2FIT_PORTABLE(normals) IM2FIT_NEON64(normals)
                                                        IM2FIT_AVX2(normals)};

}  // namespace im2fit
