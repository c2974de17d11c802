// SPDX-License-Identifier: Apache-2.0
#include "train/population/actor.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <utility>

namespace im2fit::lab {

using body::Segment;

void skin(const Actor& actor, const body::Pose& pose, std::span<Vec3f> out) {
  assert(out.size() == actor.rest.size() && actor.rest.size() == actor.surface->skin.size());
  const body::PosedSkeleton posed = body::pose_skeleton(actor.skeleton, pose);
  std::array<SkinMatrix, body::kSegmentCount> matrices;
  for (std::size_t s = 0; s < matrices.size(); ++s) {
    const auto& m = pose.rotation[s].m;
    const Vec3f shift = posed.head[s] - pose.rotation[s] * actor.skeleton.head[s];
    matrices[s] = {
        {{m[0], m[3], m[6], 0}, {m[1], m[4], m[7], 0}, {m[2], m[5], m[8], 0}, {shift.x, shift.y, shift.z, 0}}};
  }
  if (actor.rest.empty()) return;
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  im2fit::skin(&actor.rest[0].x, actor.surface->skin.data(), static_cast<int>(actor.rest.size()), matrices.data(),
               &out[0].x);
}

JointSet joints_of(const Actor& actor, const body::Pose& pose) {
  const body::PosedSkeleton bones = body::pose_skeleton(actor.skeleton, pose);
  const auto head = [&](Segment s) { return bones.head[static_cast<std::size_t>(s)]; };
  const auto tail = [&](Segment s) { return bones.tail[static_cast<std::size_t>(s)]; };
  JointSet joints;
  joints[Joint::HE] = (head(Segment::head) + tail(Segment::head)) * 0.5F;
  joints[Joint::LA] = tail(Segment::left_hand);
  joints[Joint::RA] = tail(Segment::right_hand);
  constexpr std::array<std::pair<Joint, Segment>, 12> kHeads = {{{Joint::NE, Segment::neck},
                                                                 {Joint::TO, Segment::chest},
                                                                 {Joint::LS, Segment::left_upper_arm},
                                                                 {Joint::RS, Segment::right_upper_arm},
                                                                 {Joint::LE, Segment::left_lower_arm},
                                                                 {Joint::RE, Segment::right_lower_arm},
                                                                 {Joint::LH, Segment::left_upper_leg},
                                                                 {Joint::RH, Segment::right_upper_leg},
                                                                 {Joint::LK, Segment::left_lower_leg},
                                                                 {Joint::RK, Segment::right_lower_leg},
                                                                 {Joint::LF, Segment::left_foot},
                                                                 {Joint::RF, Segment::right_foot}}};
  for (const auto& [joint, segment] : kHeads) joints[joint] = head(segment);
  joints.confidence.fill(1);
  return joints;
}

}  // namespace im2fit::lab
