// SPDX-License-Identifier: Apache-2.0
// What a picture row shows of the person: runs of pixels, their edges in mm, and the relief between them.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "core/camera.h"
#include "core/joints.h"
#include "kernels/contour/contour.h"
#include "perception/profile/person_frame.h"

namespace im2fit::profile {

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kDepthScale = 1.0F / 16.0F;
inline constexpr float kStepMm = static_cast<float>(kContourStepQ4) * kDepthScale;  // ends a run: another limb
inline constexpr int kGapPx = 2;                                                    // holes up to this wide do not

// A coordinate along one axis, of points of one row: z (per_column u + base) + offset.
struct RowAxis {
  float per_column = 0, base = 0, offset = 0;
  float at(float u, float z_mm) const { return z_mm * (per_column * u + base) + offset; }
  // The column where a surface at depth z has this coordinate.
  float column(float value, float z_mm) const { return (value - offset - z_mm * base) / (z_mm * per_column); }
};

// The same of a whole picture: the slope of a pixel's ray along the axis is linear in its column and row.
struct PictureAxis {
  PictureAxis() = default;
  PictureAxis(const Intrinsics& k, Vec3f axis, float offset_mm)
      : per_column(axis.x / k.fx),
        per_row(axis.y / k.fy),
        base(axis.z - per_column * k.cx - per_row * k.cy),
        offset(offset_mm) {}
  RowAxis row(int v) const { return {per_column, per_row * static_cast<float>(v) + base, offset}; }

  float per_column = 0, per_row = 0, base = 0, offset = 0;
};

struct Run {
  int begin = 0;                             // first pixel
  int end = 0;                               // last pixel, inclusive
  float begin_side_mm = 0, end_side_mm = 0;  // of the pixels' outer edges
};

struct Row {
  int v = 0;
  const std::uint16_t* depth = nullptr;
  const std::uint8_t* mask = nullptr;
  int width = 0;
  RowAxis height, side, toward;
  float height_mm = 0;
  std::array<Run, 24> runs;
  int run_count = 0;

  float z(int u) const { return mask[u] != 0 ? static_cast<float>(depth[u]) * kDepthScale : 0.0F; }
};

// Joints ordered from high to low, as heights and sideways positions.
template <std::size_t kCount>
struct Line {
  std::array<float, kCount> height_mm, side_mm;
  // The polyline's sideways position at a height; below its end that of the end.
  float side_at(float h) const {
    for (std::size_t i = 0; i + 1 < kCount; ++i) {
      const float h0 = height_mm[i], h1 = height_mm[i + 1];
      if (h > h1 && h0 > h1) {
        const float t = (h - h1) / (h0 - h1);
        return side_mm[i + 1] + (t < 1.0F ? t : 1.0F) * (side_mm[i] - side_mm[i + 1]);
      }
    }
    return side_mm.back();
  }
};

struct Scene {
  ImageView<const std::uint16_t> depth;
  MaskView mask;
  Intrinsics k;
  PersonFrame frame;
  const JointSet* joints = nullptr;
  float stature_mm = 0;
  float base_mm = 0;  // height of the soles
  PictureAxis height{}, side{}, toward{};
  Line<3> spine{}, left_arm{}, right_arm{}, left_leg{}, right_leg{};
  Line<2> head{};

  float z(int u, int v) const { return mask.at(u, v) != 0 ? static_cast<float>(depth.at(u, v)) * kDepthScale : 0.0F; }
  Vec3f joint(Joint j) const { return (*joints)[j]; }
  // Axes and lines of the frame as it is now.
  void set_axes();
};

// Sets the row but for its height: its runs from left to right, at most runs.size(). seen and steps: the row's words
// of the contour kernel.
void find_runs(const Scene& s, int v, const std::uint64_t* seen, const std::uint64_t* steps, Row& row);
// Depth at a pixel, looking a little sideways for a hole; 0 when there is none.
float z_near(const Row& row, int u);
// Sideways position of a run's edge at (fractional) column u_edge; depth is that of the pixel u_inside.
float side_of_edge(const Row& row, float u_edge, int u_inside);
// The run at a sideways position, or the nearest within 60 mm; null when there is none.
const Run* run_at(const Row& row, float side);
// Mean depth towards the camera of up to five pixels about column u; NaN when there is none.
float relief_at(const Row& row, float u, const Run& run);
// The same at a sideways position in mm; z_mm: the depth to begin with, > 0.
float relief_at_side(const Row& row, float side, float z_mm, const Run& run);

}  // namespace im2fit::profile
