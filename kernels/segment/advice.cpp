// SPDX-License-Identifier: Apache-2.0
#include "kernels/segment/advice.h"

#include <algorithm>

namespace im2fit::segment {
namespace {

constexpr float kNearMm = 1000.0F;
constexpr float kFarMm = 4000.0F;
constexpr float kHoleShareMax = 0.30F;
constexpr float kFeetMissingMm = 220.0F;  // lowest visible part this far above the floor: the feet are hidden
constexpr float kWholeBodyMinMm = 1250.0F;
constexpr int kDeadBorderPx = 12;  // sensors leave some columns at the border without data

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

GuidanceSet bit(Guidance g) {
  return static_cast<GuidanceSet>(g);
}

// Share of the person's pixels without data, counting lost cells with the person on two sides.
float hole_share(const Grid& grid, DepthView depth, std::span<const std::uint8_t> chosen) {
  int total = 0;
  int lost = 0;
  const auto is_person = [&](int c, int r) {
    return c >= 0 && r >= 0 && c < grid.width && r < grid.height && chosen[at(grid.index(c, r))] != 0;
  };
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const int cell = grid.index(c, r);
      if (chosen[at(cell)] == 0) {
        if (grid.depth[at(cell)] != 0) continue;
        const bool across =
            (is_person(c - 1, r) || is_person(c - 2, r)) && (is_person(c + 1, r) || is_person(c + 2, r));
        const bool along =
            (is_person(c, r - 1) || is_person(c, r - 2)) && (is_person(c, r + 1) || is_person(c, r + 2));
        if (!across || !along) continue;
      }
      for (int v = r * grid.step; v < (r + 1) * grid.step; ++v)
        for (int u = c * grid.step; u < (c + 1) * grid.step; ++u) lost += depth.at(u, v) == 0 ? 1 : 0;
      total += grid.step * grid.step;
    }
  }
  return total > 0 ? static_cast<float>(lost) / static_cast<float>(total) : 1.0F;
}

}  // namespace

void mark_dead_borders(const Grid& grid, int image_width, int image_height, Person& person) {
  int c_min = grid.width;
  int c_max = -1;
  int r_min = grid.height;
  int r_max = -1;
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      if (grid.depth[at(grid.index(c, r))] == 0) continue;
      c_min = std::min(c_min, c);
      c_max = std::max(c_max, c);
      r_min = std::min(r_min, r);
      r_max = std::max(r_max, r);
    }
  }
  const int dead = std::max(2, kDeadBorderPx * grid.step / 4);
  const auto ends = [&](int gap_px, int distance_px) { return gap_px <= dead && distance_px < grid.step; };
  const int left = c_min * grid.step;
  const int right = (c_max + 1) * grid.step - 1;
  const int top = r_min * grid.step;
  const int bottom = (r_max + 1) * grid.step - 1;
  if (ends(left, person.u_min - left)) person.cut_left = true;
  if (ends(image_width - 1 - right, right - person.u_max)) person.cut_right = true;
  if (ends(top, person.v_min - top)) person.cut_top = true;
  if (ends(image_height - 1 - bottom, bottom - person.v_max)) person.cut_bottom = true;
}

GuidanceSet advise(const Grid& grid, const Person& person, DepthView depth, MaskView mask,
                   std::span<const std::uint8_t> chosen, bool disturbed) {
  GuidanceSet out = 0;
  if (person.centroid_mm.z < kNearMm) out |= bit(Guidance::too_near);
  if (person.centroid_mm.z > kFarMm) out |= bit(Guidance::too_far);
  if (person.cut_top) out |= bit(Guidance::head_cut);
  if (person.cut_left || person.cut_right) out |= bit(Guidance::side_cut);
  if (disturbed) out |= bit(Guidance::several_people);
  if (hole_share(grid, depth, chosen) > kHoleShareMax) out |= bit(Guidance::too_noisy);
  const Vec3f up = person.floor.known ? person.floor.up : Vec3f{0, -1, 0};
  float lowest = 1e9F;
  float highest = -1e9F;
  for (int v = person.v_min; v <= person.v_max; ++v) {
    for (int u = person.u_min; u <= person.u_max; u += grid.step) {
      if (mask.at(u, v) == 0) continue;
      const float h = dot(up, unproject(grid.intrinsics, static_cast<float>(u), static_cast<float>(v),
                                        static_cast<float>(depth.at(u, v))));
      lowest = std::min(lowest, h);
      highest = std::max(highest, h);
    }
  }
  const bool feet_hidden = person.floor.known ? lowest + person.floor.camera_height_mm > kFeetMissingMm
                                              : highest - lowest < kWholeBodyMinMm;
  if (person.cut_bottom || feet_hidden) out |= bit(Guidance::feet_cut);
  return out;
}

GuidanceSet advise_nobody(const Grid& grid, std::span<const Blob> blobs) {
  GuidanceSet out = bit(Guidance::no_person);
  for (const Blob& blob : blobs) {
    const bool large = blob.cell_count * 8 > static_cast<int>(grid.depth.size());
    if (large && blob.centroid_mm.z < kNearMm) out |= bit(Guidance::too_near);
  }
  return out;
}

}  // namespace im2fit::segment
