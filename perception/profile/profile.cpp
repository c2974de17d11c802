// SPDX-License-Identifier: Apache-2.0
#include "perception/profile/profile.h"

#include <algorithm>
#include <cmath>

#include "perception/profile/crown.h"
#include "perception/profile/levels.h"
#include "perception/profile/row_scan.h"

namespace im2fit {
namespace {

using L = ProfileLayout;
using namespace profile;

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
