// SPDX-License-Identifier: Apache-2.0
#include "body/skeleton.h"

#include <cassert>
#include <cstddef>

#include "body/model_data.h"

namespace im2fit::body {
namespace {

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}
constexpr std::size_t kCount = static_cast<std::size_t>(kSegmentCount);

struct SinCos {
  float sin, cos;
};

// Taylor series on +-45 degrees (error < 1e-7), quadrants by symmetry: only + - * so that a pose has the same bits
// on every machine. |degrees| up to some thousands.
SinCos sin_cos(float degrees) {
  const float scaled = degrees * (1.0F / 90);
  const int quadrant = static_cast<int>(scaled < 0 ? scaled - 0.5F : scaled + 0.5F);
  const float x = (degrees - 90.0F * static_cast<float>(quadrant)) * 0.017453292519943295F;
  const float x2 = x * x;
  const float s = x * (1 - x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42 * (1 - x2 / 72))));
  const float c = 1 - x2 / 2 * (1 - x2 / 12 * (1 - x2 / 30 * (1 - x2 / 56)));
  switch (((quadrant % 4) + 4) % 4) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

Mat3f columns(Vec3f a, Vec3f b, Vec3f c) {
  return {{a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z}};
}

// Right-handed frame with `up` kept and `left` made perpendicular to it.
Mat3f frame(Vec3f left, Vec3f up) {
  const Vec3f y = normalized(up);
  const Vec3f x = normalized(left - y * dot(left, y));
  return columns(x, y, cross(x, y));
}

// Turns bones one by one, each by the smallest rotation from where its parent has taken it.
class PoseBuilder {
 public:
  explicit PoseBuilder(const Skeleton& rest) : rest_(rest) {}

  // Turns the bone's rest direction (head to tail), carried by `carrier`, to `direction`.
  void aim(Segment s, const Mat3f& carrier, Vec3f direction) {
    aim_line(s, carrier, rest_.tail[at(s)] - rest_.head[at(s)], direction);
  }
  // The same for a line of the segment other than its bone.
  void aim_line(Segment s, const Mat3f& carrier, Vec3f rest_line, Vec3f direction) {
    rotation(s) = rotation_between(carrier * rest_line, direction) * carrier;
  }
  Mat3f& rotation(Segment s) { return pose_.rotation[at(s)]; }
  Pose& pose() { return pose_; }

 private:
  const Skeleton& rest_;
  Pose pose_;
};

// Arms of the named poses: `clavicle_deg` lifts the shoulder girdle; directions are those of the left side.
Pose arms_pose(const Skeleton& rest, float clavicle_deg, Vec3f upper, Vec3f lower) {
  PoseBuilder b(rest);
  for (const bool left : {true, false}) {
    const Vec3f side = {left ? 1.0F : -1.0F, 1, 1};
    const auto mirrored = [&](Vec3f v) { return Vec3f{v.x * side.x, v.y, v.z}; };
    const Segment shoulder = left ? Segment::left_shoulder : Segment::right_shoulder;
    const Segment upper_arm = left ? Segment::left_upper_arm : Segment::right_upper_arm;
    const Segment lower_arm = left ? Segment::left_lower_arm : Segment::right_lower_arm;
    const Segment hand = left ? Segment::left_hand : Segment::right_hand;
    b.rotation(shoulder) = rotation_about({0, 0, side.x}, clavicle_deg);
    b.aim(upper_arm, b.rotation(shoulder), mirrored(upper));
    b.aim(lower_arm, b.rotation(upper_arm), mirrored(lower));
    b.rotation(hand) = b.rotation(lower_arm);
  }
  return b.pose();
}

}  // namespace

Mat3f operator*(const Mat3f& a, const Mat3f& b) {
  Mat3f c;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      c.m[3 * i + j] = a.m[3 * i] * b.m[j] + a.m[3 * i + 1] * b.m[3 + j] + a.m[3 * i + 2] * b.m[6 + j];
  return c;
}

Mat3f transpose(const Mat3f& a) {
  return {{a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}

// Rodrigues' formula with sin and cos taken from the cross and dot products: R = I + [v] + [v]^2 / (1 + c).
Mat3f rotation_between(Vec3f from, Vec3f to) {
  const Vec3f a = normalized(from);
  const Vec3f b = normalized(to);
  const float c = dot(a, b);
  if (dot(a, a) == 0 || dot(b, b) == 0) return {};
  if (c < -0.99999F) {  // half a turn about any perpendicular axis: 2 n n^T - I
    const Vec3f other = a.x * a.x < 0.5F ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0};
    const Vec3f n = normalized(cross(a, other));
    return {{2 * n.x * n.x - 1, 2 * n.x * n.y, 2 * n.x * n.z, 2 * n.x * n.y, 2 * n.y * n.y - 1, 2 * n.y * n.z,
             2 * n.x * n.z, 2 * n.y * n.z, 2 * n.z * n.z - 1}};
  }
  const Vec3f v = cross(a, b);
  const float k = 1 / (1 + c);
  return {{c + k * v.x * v.x, k * v.x * v.y - v.z, k * v.x * v.z + v.y, k * v.x * v.y + v.z, c + k * v.y * v.y,
           k * v.y * v.z - v.x, k * v.x * v.z - v.y, k * v.y * v.z + v.x, c + k * v.z * v.z}};
}

Mat3f rotation_about(Vec3f axis, float degrees) {
  const Vec3f n = normalized(axis);
  const auto [s, c] = sin_cos(degrees);
  const float k = 1 - c;
  return {{c + k * n.x * n.x, k * n.x * n.y - s * n.z, k * n.x * n.z + s * n.y, k * n.x * n.y + s * n.z,
           c + k * n.y * n.y, k * n.y * n.z - s * n.x, k * n.x * n.z - s * n.y, k * n.y * n.z + s * n.x,
           c + k * n.z * n.z}};
}

Skeleton rest_skeleton(const BodyModel& model, std::span<const Vec3f> rest_vertices) {
  assert(rest_vertices.size() == static_cast<std::size_t>(model.vertex_count()));
  Skeleton skeleton;
  for (std::size_t s = 0; s < kCount; ++s) {
    skeleton.head[s] = mean_of_list(model.data(), kHeadLists + s, rest_vertices);
    skeleton.tail[s] = mean_of_list(model.data(), kTailLists + s, rest_vertices);
  }
  return skeleton;
}

Pose pose_from_local(const std::array<Mat3f, kSegmentCount>& local, Vec3f translation_mm) {
  Pose pose;
  pose.translation_mm = translation_mm;
  for (std::size_t s = 0; s < kCount; ++s)
    pose.rotation[s] =
        kSegmentParent[s] < 0 ? local[s] : pose.rotation[static_cast<std::size_t>(kSegmentParent[s])] * local[s];
  return pose;
}

PosedSkeleton pose_skeleton(const Skeleton& rest, const Pose& pose) {
  PosedSkeleton posed;
  for (std::size_t s = 0; s < kCount; ++s) {
    if (kSegmentParent[s] < 0) {
      posed.head[s] = rest.head[s] + pose.translation_mm;
    } else {
      const auto p = static_cast<std::size_t>(kSegmentParent[s]);
      posed.head[s] = posed.head[p] + pose.rotation[p] * (rest.head[s] - rest.head[p]);
    }
    posed.tail[s] = posed.head[s] + pose.rotation[s] * (rest.tail[s] - rest.head[s]);
  }
  return posed;
}

Pose a_pose(const Skeleton&) {
  return {};
}

Pose relaxed_pose(const Skeleton& rest, float spread_deg) {
  const auto [s, c] = sin_cos(spread_deg);
  // The forearm hangs closer to the thigh than the upper arm and a little forward.
  const auto [s_low, c_low] = sin_cos(spread_deg * 0.8F);
  return arms_pose(rest, 0, {s, -c, -0.02F}, {s_low, -c_low, 0.2F});
}

Pose psi_pose(const Skeleton& rest) {
  return arms_pose(rest, 12, {1, 0, 0}, {0.05F, 1, 0.02F});
}

Pose arms_out_pose(const Skeleton& rest) {
  return arms_pose(rest, 14, {1, 0, 0}, {1, 0, 0});
}

Pose pose_from_joints(const Skeleton& rest, const JointSet& joints) {
  const auto head = [&](Segment s) { return rest.head[at(s)]; };
  PoseBuilder b(rest);
  PosedSkeleton posed;
  const auto place = [&](Segment s, Segment parent) {
    posed.head[at(s)] = posed.head[at(parent)] + b.rotation(parent) * (head(s) - head(parent));
  };

  const Vec3f hips = (joints[Joint::LH] + joints[Joint::RH]) * 0.5F;
  const Vec3f rest_left = head(Segment::left_upper_leg) - head(Segment::right_upper_leg);
  const Mat3f pelvis = frame(joints[Joint::LH] - joints[Joint::RH], joints[Joint::TO] - hips) *
                       transpose(frame(rest_left, head(Segment::chest) - head(Segment::pelvis)));
  b.rotation(Segment::pelvis) = pelvis;
  b.pose().translation_mm = hips - head(Segment::pelvis);
  posed.head[at(Segment::pelvis)] = hips;

  place(Segment::abdomen, Segment::pelvis);
  b.aim(Segment::abdomen, pelvis, joints[Joint::TO] - posed.head[at(Segment::abdomen)]);
  const Vec3f rest_shoulders = head(Segment::left_upper_arm) - head(Segment::right_upper_arm);
  const Mat3f chest = frame(joints[Joint::LS] - joints[Joint::RS], joints[Joint::NE] - joints[Joint::TO]) *
                      transpose(frame(rest_shoulders, head(Segment::neck) - head(Segment::chest)));
  b.rotation(Segment::chest) = chest;
  place(Segment::chest, Segment::abdomen);

  // HE is the middle of the skull: neck and head turn as one.
  const Vec3f rest_skull = (rest.head[at(Segment::head)] + rest.tail[at(Segment::head)]) * 0.5F;
  b.aim_line(Segment::neck, chest, rest_skull - head(Segment::neck), joints[Joint::HE] - joints[Joint::NE]);
  b.rotation(Segment::head) = b.rotation(Segment::neck);

  const auto arm = [&](Segment shoulder, Joint js, Joint je, Joint jh) {
    const auto next = [&](Segment s, std::size_t steps) { return static_cast<Segment>(at(s) + steps); };
    const Segment upper = next(shoulder, 1), lower = next(shoulder, 2), hand = next(shoulder, 3);
    place(shoulder, Segment::chest);
    b.aim(shoulder, chest, joints[js] - posed.head[at(shoulder)]);
    b.aim(upper, b.rotation(shoulder), joints[je] - joints[js]);
    b.aim_line(lower, b.rotation(upper), rest.tail[at(hand)] - head(lower), joints[jh] - joints[je]);
    b.rotation(hand) = b.rotation(lower);
  };
  arm(Segment::left_shoulder, Joint::LS, Joint::LE, Joint::LA);
  arm(Segment::right_shoulder, Joint::RS, Joint::RE, Joint::RA);

  const auto leg = [&](Segment upper, Segment lower, Segment foot, Joint jh, Joint jk, Joint jf) {
    b.aim(upper, pelvis, joints[jk] - joints[jh]);
    b.aim(lower, b.rotation(upper), joints[jf] - joints[jk]);
    // No joint says where the toes point: the sole stays level, turned as the leg is turned.
    const Vec3f up = {0, 1, 0};
    b.rotation(foot) = rotation_between(b.rotation(lower) * up, up) * b.rotation(lower);
  };
  leg(Segment::left_upper_leg, Segment::left_lower_leg, Segment::left_foot, Joint::LH, Joint::LK, Joint::LF);
  leg(Segment::right_upper_leg, Segment::right_lower_leg, Segment::right_foot, Joint::RH, Joint::RK, Joint::RF);
  return b.pose();
}

void skin(const BodyModel& model, std::span<const Vec3f> rest_vertices, const Skeleton& rest, const Pose& pose,
          std::span<Vec3f> out) {
  assert(out.size() == rest_vertices.size());
  assert(rest_vertices.size() <= static_cast<std::size_t>(model.vertex_count()));
  const PosedSkeleton posed = pose_skeleton(rest, pose);
  std::array<SkinMatrix, kCount> matrices;
  for (std::size_t s = 0; s < kCount; ++s) {
    const auto& m = pose.rotation[s].m;
    const Vec3f shift = posed.head[s] - pose.rotation[s] * rest.head[s];
    matrices[s] = {
        {{m[0], m[3], m[6], 0}, {m[1], m[4], m[7], 0}, {m[2], m[5], m[8], 0}, {shift.x, shift.y, shift.z, 0}}};
  }
  if (rest_vertices.empty()) return;
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  im2fit::skin(&rest_vertices[0].x, model.data().skin.data(), static_cast<int>(rest_vertices.size()), matrices.data(),
               &out[0].x);
}

JointSet joints_of(const BodyModel& model, std::span<const Vec3f> posed_vertices) {
  assert(posed_vertices.size() == static_cast<std::size_t>(model.vertex_count()));
  JointSet joints;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    joints.position_mm[j] = mean_of_list(model.data(), kOpenNiLists + j, posed_vertices);
    joints.confidence[j] = 1;
  }
  return joints;
}

}  // namespace im2fit::body
