// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/dressing_pose.h"

#include <array>
#include <cmath>

#include "body/model_data.h"

namespace im2fit::body {
namespace {

std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

using Quaternion = std::array<float, 4>;  // x, y, z, w

Quaternion unit(Quaternion q) {
  const float n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (float& c : q) c /= n;
  return q;
}

// From the largest of the four: no division by small numbers.
Quaternion quaternion_of(const Mat3f& rotation) {
  const auto& m = rotation.m;
  const Quaternion squares = {1 + m[0] - m[4] - m[8], 1 - m[0] + m[4] - m[8], 1 - m[0] - m[4] + m[8],
                              1 + m[0] + m[4] + m[8]};
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) best = squares[i] > squares[best] ? i : best;
  if (best == 0) return unit({squares[0], m[1] + m[3], m[2] + m[6], m[7] - m[5]});
  if (best == 1) return unit({m[1] + m[3], squares[1], m[5] + m[7], m[2] - m[6]});
  if (best == 2) return unit({m[2] + m[6], m[5] + m[7], squares[2], m[3] - m[1]});
  return unit({m[7] - m[5], m[2] - m[6], m[3] - m[1], squares[3]});
}

Mat3f matrix_of(const Quaternion& q) {
  const float x = q[0], y = q[1], z = q[2], w = q[3];
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w),
           1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w),
           1 - 2 * (x * x + y * y)}};
}

Mat3f between_rotations(const Mat3f& a, const Mat3f& b, float share) {
  const Quaternion p = quaternion_of(a), q = quaternion_of(b);
  const float same = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
  const float sign = same < 0 ? -1.0F : 1.0F;
  Quaternion mixed{};
  for (std::size_t i = 0; i < 4; ++i) mixed[i] = (1 - share) * p[i] + share * sign * q[i];
  return matrix_of(unit(mixed));
}

Mat3f local_of(const Pose& pose, std::size_t s) {
  const int parent = kSegmentParent[s];
  return parent < 0 ? pose.rotation[s]
                    : transpose(pose.rotation[static_cast<std::size_t>(parent)]) * pose.rotation[s];
}

bool is_trunk(Segment s) {
  return s <= Segment::head;
}

Vec3f on_line(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3f ab = b - a;
  const float squared = dot(ab, ab);
  float share = squared > 0 ? dot(p - a, ab) / squared : 0;
  share = share < 0 ? 0 : share > 1 ? 1 : share;
  return a + ab * share;
}

}  // namespace

Pose dressing_pose(const Skeleton& rest) {
  Pose pose;
  for (const bool left : {true, false}) {
    const float side = left ? 1.0F : -1.0F;
    const auto aim = [&](Segment s, Vec3f direction) {
      pose.rotation[at(s)] = rotation_between(rest.tail[at(s)] - rest.head[at(s)], direction);
    };
    const Vec3f arm = {side * kRaisedArmCosine, -kRaisedArmSine, 0},
                leg = {side * kSpreadLegSine, -kSpreadLegCosine, 0};
    aim(left ? Segment::left_upper_arm : Segment::right_upper_arm, arm);
    aim(left ? Segment::left_lower_arm : Segment::right_lower_arm, arm);
    aim(left ? Segment::left_hand : Segment::right_hand, arm);
    aim(left ? Segment::left_upper_leg : Segment::right_upper_leg, leg);
    aim(left ? Segment::left_lower_leg : Segment::right_lower_leg, leg);
  }
  return pose;
}

Pose between(const Pose& a, const Pose& b, float share) {
  std::array<Mat3f, kSegmentCount> local;
  for (std::size_t s = 0; s < local.size(); ++s) local[s] = between_rotations(local_of(a, s), local_of(b, s), share);
  return pose_from_local(local, a.translation_mm + (b.translation_mm - a.translation_mm) * share);
}

void bone_axes(const BodyModel& model, const PosedSkeleton& bones, std::span<const Vec3f> posed,
               std::span<Vec3f> out) {
  const auto& skin = model.data().skin;
  const float middle_x = bones.head[at(Segment::pelvis)].x;
  for (std::size_t v = 0; v < out.size(); ++v) {
    const Vec3f p = posed[v];
    Vec3f axis{};
    for (std::size_t k = 0; k < 4; ++k) {
      const auto s = static_cast<Segment>(skin[v].segment[k]);
      const Vec3f near = is_trunk(s) ? Vec3f{middle_x, p.y, p.z} : on_line(p, bones.head[at(s)], bones.tail[at(s)]);
      axis = axis + near * skin[v].weight[k];
    }
    out[v] = axis;
  }
}

void draw_in(const DrawnIn& drawn, std::span<const Vec3f> axes, std::span<const Vec3f> posed, std::span<Vec3f> out) {
  for (std::size_t v = 0; v < out.size(); ++v) {
    const Vec3f p = posed[v], axis = axes[v];
    out[v] = {axis.x + drawn.sideways * (p.x - axis.x), axis.y + drawn.sideways * (p.y - axis.y),
              drawn.middle_z + drawn.depth * (p.z - drawn.middle_z)};
  }
}

}  // namespace im2fit::body
