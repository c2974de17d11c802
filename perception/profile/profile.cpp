// SPDX-License-Identifier: Apache-2.0
#include "perception/profile/profile.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "perception/profile/crown.h"
#include "perception/profile/row_scan.h"

namespace im2fit {
namespace {

using L = ProfileLayout;
using namespace profile;

// Rows of trunk, legs and head accumulated into levels at fixed parts of the stature.

constexpr int kLevelFloats = L::kArms;  // trunk, legs and head lie before the arms in the layout
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

// Adds a row's values to the levels it lies between, in every band it belongs to.
void add_row(const Scene& s, const Row& row, ProfileWorkspace& work) {
  if (in_band(s, kTrunkBand, row.height_mm)) add_trunk_row(s, row, work);
  if (in_band(s, kLegBand, row.height_mm)) add_leg_row(s, row, work);
  if (in_band(s, kHeadBand, row.height_mm)) add_head_row(s, row, work);
}

// Width of a limb across the picture at pixel (u, v), along the unit direction (du, dv).
float width_across(const Scene& s, float u, float v, float du, float dv) {
  const auto z_at = [&](float x, float y) {
    // Not below zero, so that cutting off is rounding down.
    if (!(x >= -0.5F && y >= -0.5F)) return 0.0F;
    if (!(x < static_cast<float>(s.mask.width) && y < static_cast<float>(s.mask.height))) return 0.0F;
    const int iu = static_cast<int>(x + 0.5F), iv = static_cast<int>(y + 0.5F);
    return iu < s.mask.width && iv < s.mask.height ? s.z(iu, iv) : 0.0F;
  };
  const float centre = z_at(u, v);
  if (centre <= 0) return kNaN;
  const float limit_px = 130.0F * s.k.fx / centre;
  float total = 0;
  for (int sign = -1; sign <= 1; sign += 2) {
    float t = 0.5F;
    while (t < limit_px) {
      const float z = z_at(u + du * t * static_cast<float>(sign), v + dv * t * static_cast<float>(sign));
      if (z <= 0 || std::abs(z - centre) > kStepMm) break;
      t += 0.5F;
    }
    total += t - 0.25F;
  }
  return total * centre / s.k.fx;
}

void arm_widths(const Scene& s, std::span<float> out) {
  const std::array<std::array<Joint, 2>, 4> bones = {
      {{Joint::LS, Joint::LE}, {Joint::LE, Joint::LA}, {Joint::RS, Joint::RE}, {Joint::RE, Joint::RA}}};
  std::size_t at = 0;
  for (const auto& bone : bones) {
    const Vec3f a = s.joint(bone[0]);
    const Vec3f b = s.joint(bone[1]);
    for (int q = 1; q <= 3; ++q, ++at) {
      out[at] = kNaN;
      const Vec3f p = a + (b - a) * (0.25F * static_cast<float>(q));
      if (a.z <= 0 || b.z <= 0 || p.z <= 0) continue;
      const float du = s.k.fx * (b.x / b.z - a.x / a.z);
      const float dv = s.k.fy * (b.y / b.z - a.y / a.z);
      const float length = std::sqrt(du * du + dv * dv);
      if (length < 4.0F) continue;
      out[at] = width_across(s, s.k.fx * p.x / p.z + s.k.cx, s.k.fy * p.y / p.z + s.k.cy, -dv / length, du / length);
    }
  }
}

void joints_and_bones(const Scene& s, std::span<float> positions, std::span<float> bones) {
  const Vec3f torso = s.joint(Joint::TO);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vec3f p = s.joints->position_mm[j];
    positions[3 * j] = s.frame.side(p) - s.frame.side(torso);
    positions[3 * j + 1] = s.frame.height(p);
    positions[3 * j + 2] = s.frame.depth(p) - s.frame.depth(torso);
  }
  using enum Joint;
  constexpr std::array<std::array<Joint, 2>, L::kBones> kPairs = {{{HE, NE},
                                                                   {NE, TO},
                                                                   {NE, LS},
                                                                   {NE, RS},
                                                                   {LS, LE},
                                                                   {RS, RE},
                                                                   {LE, LA},
                                                                   {RE, RA},
                                                                   {LS, RS},
                                                                   {LH, RH},
                                                                   {LH, LK},
                                                                   {RH, RK},
                                                                   {LK, LF},
                                                                   {RK, RF}}};
  for (std::size_t i = 0; i < kPairs.size(); ++i) bones[i] = norm(s.joint(kPairs[i][0]) - s.joint(kPairs[i][1]));
}

// What the picture's geometry adds to widths and heights; lets the projection take it out again.
void scene_values(const Scene& s, std::span<const ContourRow> outline, std::span<float> out) {
  std::uint64_t count = 0, depth_sum = 0, square_sum = 0;
  for (const ContourRow& row : outline) {
    count += row.count;
    depth_sum += row.depth_sum;
    square_sum += row.depth_square_sum;
  }
  const auto area = static_cast<float>(static_cast<double>(square_sum) / (256.0 * double{s.k.fx} * double{s.k.fy}));
  const auto mean_z = static_cast<float>(static_cast<double>(depth_sum) / (16.0 * static_cast<double>(count)));
  const Vec3f shoulders = s.joint(Joint::LS) - s.joint(Joint::RS);
  const Vec3f hips = s.joint(Joint::LH) - s.joint(Joint::RH);
  out[0] = count > 0 ? mean_z : kNaN;
  out[1] = area;
  out[2] = area / s.stature_mm;
  out[3] = s.frame.camera_height_mm;
  out[4] = s.frame.up.z;
  out[5] = dot(s.frame.toward, normalized(shoulders));
  out[6] = dot(s.frame.toward, normalized(hips));
  out[7] = s.base_mm;
}

}  // namespace

ProfileWorkspace::ProfileWorkspace(int width_max, int height_max)
    : rays(width_max, height_max),
      up(width_max, height_max),
      side(width_max, height_max),
      outline(static_cast<std::size_t>(height_max)),
      seen(static_cast<std::size_t>(height_max) * contour_words(width_max)),
      steps(seen.size()),
      squares(kHeightBins),
      level_sum(kLevelFloats),
      level_weight(kLevelFloats) {}

namespace {

void accumulate_levels(const Scene& s, ProfileWorkspace& work, std::span<float> out) {
  std::fill(work.level_sum.begin(), work.level_sum.end(), 0.0F);
  std::fill(work.level_weight.begin(), work.level_weight.end(), 0.0F);
  const float torso_side = s.frame.side(s.joint(Joint::TO));
  const std::size_t words = contour_words(s.mask.width);
  Row row;
  for (int v = 0; v < s.mask.height; ++v) {
    const auto at = static_cast<std::size_t>(v);
    if (work.outline[at].count == 0) continue;
    find_runs(s, v, work.seen.data() + at * words, work.steps.data() + at * words, row);
    const Run* centre = run_at(row, torso_side);
    const Run& any = centre != nullptr ? *centre : row.runs[0];
    const int u = (any.begin + any.end) / 2;
    const float z = z_near(row, u);
    row.height_mm = row.height.at(static_cast<float>(u), z > 0 ? z : z_near(row, any.begin));
    add_row(s, row, work);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(L::kArms); ++i)
    if (work.level_weight[i] > 0.3F) out[i] = work.level_sum[i] / work.level_weight[i];
}

}  // namespace

void section_profile(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                     const JointSet& joints, const FloorPlane& floor, ProfileWorkspace& work, std::span<float> out) {
  std::fill(out.begin(), out.end(), kNaN);
  Scene s{depth_q4, mask, intrinsics, person_frame(floor, joints[Joint::TO]), &joints};
  // A torso that is nowhere has no frame.
  if (!(norm(s.frame.up) > 0.5F && norm(s.frame.right) > 0.5F)) return;
  const auto part = [&](int first, int size) {
    return out.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size));
  };
  set_camera(work.rays, intrinsics);
  work.up.set(work.rays, s.frame.up);
  work.side.set(work.rays, s.frame.right);
  contour(depth_q4, mask, work.outline.data(), work.seen.data(), work.steps.data());

  const auto crown = part(L::kCrown, L::kCrownValues);
  const auto soles = part(L::kSoles, L::kSoleValues);
  crown_and_soles(s, floor.known, work, crown, soles);
  if (std::isnan(crown[1]) || std::isnan(soles[1])) return;
  if (!floor.known) s.base_mm = soles[0];
  s.stature_mm = crown[1] - s.base_mm;
  if (s.stature_mm < 800.0F || s.stature_mm > 2600.0F) return;
  s.set_axes();
  accumulate_levels(s, work, out);

  arm_widths(s, part(L::kArms, L::kArmValues));
  joints_and_bones(s, part(L::kJoints, 3 * static_cast<int>(kJointCount)), part(L::kBoneLengths, L::kBones));
  scene_values(s, std::span(work.outline).first(static_cast<std::size_t>(mask.height)),
               part(L::kSceneValues, L::kScene));
  if (!floor.known) {
    for (float& h : crown) h -= s.base_mm;
    for (float& h : soles) h -= s.base_mm;
  }
}

}  // namespace im2fit
