// SPDX-License-Identifier: Apache-2.0
#include "kernels/profile/row_scan.h"

#include <algorithm>
#include <cmath>

namespace im2fit::profile {

int find_runs(const Scene& s, int v, std::span<Run> runs) {
  int count = 0;
  int last = -100;
  float last_z = 0;
  for (int u = 0; u < s.mask.width; ++u) {
    const float z = s.z(u, v);
    if (z <= 0) continue;
    const bool joins = count > 0 && u - last <= kGapPx + 1 && std::abs(z - last_z) < kStepMm;
    if (joins) {
      runs[static_cast<std::size_t>(count - 1)].end = u;
    } else {
      if (count == static_cast<int>(runs.size())) break;
      runs[static_cast<std::size_t>(count++)] = {u, u};
    }
    last = u;
    last_z = z;
  }
  return count;
}

float z_near(const Scene& s, int u, int v) {
  for (int d = 0; d <= kGapPx; ++d) {
    if (u - d >= 0 && s.z(u - d, v) > 0) return s.z(u - d, v);
    if (u + d < s.mask.width && s.z(u + d, v) > 0) return s.z(u + d, v);
  }
  return 0;
}

float side_of_edge(const Scene& s, float u_edge, int u_inside, int v) {
  return s.frame.side(s.point(u_edge, v, z_near(s, u_inside, v)));
}

float line_side(const Scene& s, std::span<const Vec3f> line, float h) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const float h0 = s.frame.height(line[i]);
    const float h1 = s.frame.height(line[i + 1]);
    if (h > h1 && h0 > h1) {
      const float t = std::min(1.0F, (h - h1) / (h0 - h1));
      return s.frame.side(line[i + 1]) + t * (s.frame.side(line[i]) - s.frame.side(line[i + 1]));
    }
  }
  return s.frame.side(line.back());
}

float column_of_side(const Scene& s, float side, int v, float z_mm) {
  const Vec3f p = s.point(0, v, z_mm);
  const float per_px = z_mm / s.k.fx * s.frame.right.x;  // right is nearly the camera's x
  return (side - s.frame.side(p)) / per_px;
}

const Run* run_at(const Scene& s, const Row& row, float side) {
  const Run* best = nullptr;
  float best_gap = 60.0F;  // farther than this from every run: there is none
  for (int i = 0; i < row.run_count; ++i) {
    const Run& r = row.runs[static_cast<std::size_t>(i)];
    const float a = side_of_edge(s, static_cast<float>(r.begin) - 0.5F, r.begin, row.v);
    const float b = side_of_edge(s, static_cast<float>(r.end) + 0.5F, r.end, row.v);
    const float gap = side < a ? a - side : side > b ? side - b : 0.0F;
    if (gap < best_gap) {
      best_gap = gap;
      best = &r;
    }
  }
  return best;
}

float relief_at(const Scene& s, float u, int v, const Run& run) {
  const int c = static_cast<int>(u + 0.5F);
  float sum = 0;
  int n = 0;
  for (int x = std::max(run.begin, c - 2); x <= std::min(run.end, c + 2); ++x) {
    const float z = s.z(x, v);
    if (z <= 0) continue;
    sum += s.frame.depth(s.point(static_cast<float>(x), v, z));
    ++n;
  }
  return n > 0 ? sum / static_cast<float>(n) : kNaN;
}

// The column depends on the depth there, so it is looked up twice.
float relief_at_side(const Scene& s, float side, int v, const Run& run) {
  const auto clamped = [&](float u) {
    return std::clamp(u, static_cast<float>(run.begin), static_cast<float>(run.end));
  };
  const float z_guess = z_near(s, (run.begin + run.end) / 2, v);
  if (z_guess <= 0) return kNaN;
  const float u = clamped(column_of_side(s, side, v, z_guess));
  const float z = z_near(s, static_cast<int>(u + 0.5F), v);
  return relief_at(s, z > 0 ? clamped(column_of_side(s, side, v, z)) : u, v, run);
}

}  // namespace im2fit::profile
