// SPDX-License-Identifier: Apache-2.0
#include "perception/profile/levels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace im2fit::profile {
namespace {

using L = ProfileLayout;
constexpr float kArmRadiusMm = 48.0F;

struct Band {
  int levels;
  float low, high;  // of stature
  int values;
};
constexpr Band kTrunkBand{L::kTrunkLevels, 0.44F, 0.84F, L::kTrunkValues};
constexpr Band kLegBand{L::kLegLevels, 0.05F, 0.45F, L::kLegValues};
constexpr Band kHeadBand{L::kHeadLevels, 0.82F, 0.98F, L::kHeadValues};

// Adds a row's values to the two levels it lies between, by nearness.
void add_to_levels(const Scene& s, const Band& band, int first, float height_mm, std::span<const float> values,
                   ProfileWorkspace& work) {
  const float t = (height_mm - s.base_mm) / s.stature_mm;
  const float position = (t - band.low) / (band.high - band.low) * static_cast<float>(band.levels - 1);
  const float below = std::floor(position);
  for (int side = 0; side < 2; ++side) {
    const int level = static_cast<int>(below) + side;
    if (level < 0 || level >= band.levels) continue;
    const float weight = side == 0 ? 1.0F - (position - below) : position - below;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) continue;
      const auto at = static_cast<std::size_t>(first + level * band.values) + i;
      work.level_sum[at] += weight * values[i];
      work.level_weight[at] += weight;
    }
  }
}

bool in_band(const Scene& s, const Band& band, float height_mm) {
  const float t = (height_mm - s.base_mm) / s.stature_mm;
  const float step = (band.high - band.low) / static_cast<float>(band.levels - 1);
  return t > band.low - step && t < band.high + step;
}

// Ends the trunk's run where an arm grows out of it: at the arm's centre line less its radius.
Run clip_arms(const Scene& s, const Row& row, Run run) {
  const float z = z_near(row, (run.begin + run.end) / 2);
  if (z <= 0) return run;
  const float shoulder_h = 0.5F * (s.left_arm.height_mm[0] + s.right_arm.height_mm[0]);
  if (row.height_mm > shoulder_h + 20.0F) return run;
  const float u_left = row.side.column(s.left_arm.side_at(row.height_mm), z);  // picture's right
  const float u_right = row.side.column(s.right_arm.side_at(row.height_mm), z);
  const float radius_px = kArmRadiusMm * s.k.fx / z;
  if (static_cast<float>(run.end) > u_left) {
    run.end = std::max(run.begin, static_cast<int>(u_left - radius_px));
    run.end_side_mm = side_of_edge(row, static_cast<float>(run.end) + 0.5F, run.end);
  }
  if (static_cast<float>(run.begin) < u_right) {
    run.begin = std::min(run.end, static_cast<int>(u_right + radius_px) + 1);
    run.begin_side_mm = side_of_edge(row, static_cast<float>(run.begin) - 0.5F, run.begin);
  }
  return run;
}

void add_trunk_row(const Scene& s, const Row& row, ProfileWorkspace& work) {
  const float axis = s.spine.side_at(row.height_mm);
  const Run* found = run_at(row, axis);
  if (found == nullptr) return;
  const Run run = clip_arms(s, row, *found);
  if (run.end - run.begin < 8) return;

  std::array<float, L::kTrunkValues> values{};
  const float a = run.begin_side_mm, b = run.end_side_mm;
  values[0] = axis - a;
  values[1] = b - axis;
  const float half = 0.5F * (b - a);
  const float middle_z = z_near(row, (run.begin + run.end) / 2);
  std::array<float, L::kReliefs> reliefs;
  reliefs.fill(kNaN);
  constexpr int kMiddle = L::kReliefs / 2;
  for (int i = 0; i < L::kReliefs && middle_z > 0; ++i)
    reliefs[static_cast<std::size_t>(i)] =
        relief_at_side(row, a + half * (1.0F + 0.2F * static_cast<float>(i - kMiddle)), middle_z, run);
  // Relative to the level's own front, so that leaning and distance do not matter.
  float front = 0;
  for (int i = 2; i <= 6; ++i) front += reliefs[static_cast<std::size_t>(i)] * 0.2F;
  float arc = 0;
  const float step = 0.1F * (b - a);
  for (std::size_t i = 0; i < reliefs.size(); ++i) {
    values[2 + i] = reliefs[i] - front;
    if (i > 0) {
      const float rise = reliefs[i] - reliefs[i - 1];
      arc += std::sqrt(step * step + rise * rise);
    }
  }
  values[2 + L::kReliefs] = arc;
  add_to_levels(s, kTrunkBand, L::kTrunk, row.height_mm, values, work);
}

void add_leg_row(const Scene& s, const Row& row, ProfileWorkspace& work) {
  const std::array<float, 2> centre = {s.left_leg.side_at(row.height_mm), s.right_leg.side_at(row.height_mm)};
  const std::array<const Run*, 2> runs = {run_at(row, centre[0]), run_at(row, centre[1])};
  if (runs[0] == nullptr || runs[1] == nullptr) return;
  std::array<float, L::kLegValues> values{};
  for (std::size_t leg = 0; leg < 2; ++leg) {
    const Run& r = *runs[leg];
    float a = r.begin_side_mm, b = r.end_side_mm;
    if (runs[0] == runs[1]) {  // thighs touch: they meet half way
      const float middle = 0.5F * (centre[0] + centre[1]);
      (leg == 0 ? a : b) = middle;
    }
    values[leg] = b - a;
    const float z = z_near(row, (r.begin + r.end) / 2);
    const float u = z > 0 ? row.side.column(0.5F * (a + b), z) : static_cast<float>(r.begin);
    values[2 + leg] = relief_at(row, u, r);
  }
  add_to_levels(s, kLegBand, L::kLegs, row.height_mm, values, work);
}

void add_head_row(const Scene& s, const Row& row, ProfileWorkspace& work) {
  const Run* run = run_at(row, s.head.side_at(row.height_mm));
  if (run == nullptr || run->end - run->begin < 4) return;
  std::array<float, L::kHeadValues> values{};
  values[0] = run->end_side_mm - run->begin_side_mm;
  const float centre_u = 0.5F * static_cast<float>(run->begin + run->end);
  const float half_u = 0.5F * static_cast<float>(run->end - run->begin);
  const float torso = s.frame.depth(s.joint(Joint::TO));
  for (int i = 0; i < 3; ++i)
    values[static_cast<std::size_t>(1 + i)] =
        relief_at(row, centre_u + half_u * 0.5F * static_cast<float>(i - 1), *run) - torso;
  add_to_levels(s, kHeadBand, L::kHead, row.height_mm, values, work);
}

}  // namespace

void add_row(const Scene& s, const Row& row, ProfileWorkspace& work) {
  if (in_band(s, kTrunkBand, row.height_mm)) add_trunk_row(s, row, work);
  if (in_band(s, kLegBand, row.height_mm)) add_leg_row(s, row, work);
  if (in_band(s, kHeadBand, row.height_mm)) add_head_row(s, row, work);
}

}  // namespace im2fit::profile
