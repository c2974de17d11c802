// SPDX-License-Identifier: Apache-2.0
// What a picture row shows of the person: runs of pixels, their edges in mm, and the relief between them.
#pragma once

#include <array>
#include <limits>
#include <span>

#include "kernels/core/camera.h"
#include "kernels/core/joints.h"
#include "kernels/profile/person_frame.h"

namespace im2fit::profile {

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kDepthScale = 1.0F / 16.0F;
inline constexpr float kStepMm = 70.0F;  // a larger jump from pixel to pixel ends a run: another limb
inline constexpr int kGapPx = 2;         // holes up to this wide do not end a run

struct Scene {
  ImageView<const std::uint16_t> depth;
  MaskView mask;
  Intrinsics k;
  PersonFrame frame;
  const JointSet* joints;
  float stature_mm = 0;
  float base_mm = 0;  // height of the soles

  float z(int u, int v) const { return mask.at(u, v) != 0 ? static_cast<float>(depth.at(u, v)) * kDepthScale : 0.0F; }
  Vec3f point(float u, int v, float z_mm) const { return unproject(k, u, static_cast<float>(v), z_mm); }
  Vec3f joint(Joint j) const { return (*joints)[j]; }
};

struct Run {
  int begin = 0;  // first pixel
  int end = 0;    // last pixel, inclusive
};

struct Row {
  int v = 0;
  float height_mm = 0;
  std::array<Run, 24> runs;
  int run_count = 0;
};

// Runs of row v, from left to right; at most runs.size().
int find_runs(const Scene& s, int v, std::span<Run> runs);
// Depth at a pixel, looking a little sideways for a hole; 0 when there is none.
float z_near(const Scene& s, int u, int v);
// Sideways position of a run's edge at (fractional) column u_edge; depth is that of the pixel u_inside.
float side_of_edge(const Scene& s, float u_edge, int u_inside, int v);
// Sideways position at height h of the polyline through joints ordered from high to low.
float line_side(const Scene& s, std::span<const Vec3f> line, float h);
// Pixel column where the row crosses sideways position `side`, at depth z.
float column_of_side(const Scene& s, float side, int v, float z_mm);
// The run at a sideways position, or the nearest within 60 mm; null when there is none.
const Run* run_at(const Scene& s, const Row& row, float side);
// Mean depth towards the camera of up to five pixels about column u; NaN when there is none.
float relief_at(const Scene& s, float u, int v, const Run& run);
// The same at a sideways position in mm.
float relief_at_side(const Scene& s, float side, int v, const Run& run);

}  // namespace im2fit::profile
