// SPDX-License-Identifier: Apache-2.0
#include "kernels/profile/profile.h"

#include <algorithm>
#include <cmath>

#include "kernels/profile/crown.h"
#include "kernels/profile/levels.h"
#include "kernels/profile/row_scan.h"

namespace im2fit {
namespace {

using L = ProfileLayout;
using namespace profile;

// Width of a limb across the picture at pixel (u, v), along the unit direction (du, dv).
float width_across(const Scene& s, float u, float v, float du, float dv) {
  const auto z_at = [&](float x, float y) {
    const int iu = static_cast<int>(std::floor(x + 0.5F));
    const int iv = static_cast<int>(std::floor(y + 0.5F));
    if (iu < 0 || iv < 0 || iu >= s.mask.width || iv >= s.mask.height) return 0.0F;
    return s.z(iu, iv);
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
void scene_values(const Scene& s, std::span<float> out) {
  float area = 0;
  float count = 0;
  float mean_z = 0;
  for (int v = 0; v < s.mask.height; ++v) {
    float row_area = 0;
    for (int u = 0; u < s.mask.width; ++u) {
      const float z = s.z(u, v);
      if (z <= 0) continue;
      row_area += z * z;
      mean_z += z;
      count += 1.0F;
    }
    area += row_area / (s.k.fx * s.k.fy);
  }
  const Vec3f shoulders = s.joint(Joint::LS) - s.joint(Joint::RS);
  const Vec3f hips = s.joint(Joint::LH) - s.joint(Joint::RH);
  out[0] = count > 0 ? mean_z / count : kNaN;
  out[1] = area;
  out[2] = area / s.stature_mm;
  out[3] = s.frame.camera_height_mm;
  out[4] = s.frame.up.z;
  out[5] = dot(s.frame.toward, normalized(shoulders));
  out[6] = dot(s.frame.toward, normalized(hips));
  out[7] = s.base_mm;
}

}  // namespace

ProfileWorkspace::ProfileWorkspace()
    : height_area(kHeightBins), level_sum(kLevelFloats), level_weight(kLevelFloats) {}

void section_profile(ImageView<const std::uint16_t> depth_q4, MaskView mask, const Intrinsics& intrinsics,
                     const JointSet& joints, const FloorPlane& floor, ProfileWorkspace& work, std::span<float> out) {
  std::fill(out.begin(), out.end(), kNaN);
  Scene s{depth_q4, mask, intrinsics, person_frame(floor, joints[Joint::TO]), &joints};
  const auto part = [&](int first, int size) {
    return out.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size));
  };

  const auto crown = part(L::kCrown, L::kCrownValues);
  const auto soles = part(L::kSoles, L::kSoleValues);
  crown_and_soles(s, floor.known, work, crown, soles);
  if (std::isnan(crown[1]) || std::isnan(soles[1])) return;
  if (!floor.known) s.base_mm = soles[0];
  s.stature_mm = crown[1] - s.base_mm;
  if (s.stature_mm < 800.0F || s.stature_mm > 2600.0F) return;

  std::fill(work.level_sum.begin(), work.level_sum.end(), 0.0F);
  std::fill(work.level_weight.begin(), work.level_weight.end(), 0.0F);
  const float torso_side = s.frame.side(joints[Joint::TO]);
  Row row;
  for (int v = 0; v < mask.height; ++v) {
    row.v = v;
    row.run_count = find_runs(s, v, row.runs);
    if (row.run_count == 0) continue;
    const Run* centre = run_at(s, row, torso_side);
    const Run& any = centre != nullptr ? *centre : row.runs[0];
    const int u = (any.begin + any.end) / 2;
    row.height_mm = s.frame.height(
        s.point(static_cast<float>(u), v, z_near(s, u, v) > 0 ? z_near(s, u, v) : z_near(s, any.begin, v)));
    add_row(s, row, work);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(L::kArms); ++i)
    if (work.level_weight[i] > 0.3F) out[i] = work.level_sum[i] / work.level_weight[i];

  arm_widths(s, part(L::kArms, L::kArmValues));
  joints_and_bones(s, part(L::kJoints, 3 * static_cast<int>(kJointCount)), part(L::kBoneLengths, L::kBones));
  scene_values(s, part(L::kSceneValues, L::kScene));
  if (!floor.known) {
    for (float& h : crown) h -= s.base_mm;
    for (float& h : soles) h -= s.base_mm;
  }
}

}  // namespace im2fit
