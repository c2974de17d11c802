// SPDX-License-Identifier: Apache-2.0
// A part of a row by portable arithmetic: also where the hand-written tiers have no whole vector.
#pragma once

namespace im2fit::normals_detail {

// Pixels u_begin <= u < u_end of row v; the rest as of normals(). Writes nowhere else.
void normals_of_row(const float* x, const float* y, const float* z, int width, int height, int v, int u_begin,
                    int u_end, int radius_px, float max_step_mm, float* nx, float* ny, float* nz);

}  // namespace im2fit::normals_detail
