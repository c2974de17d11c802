// SPDX-License-Identifier: Apache-2.0
#include "train/population/poses.h"

#include <array>
#include <cmath>
#include <vector>

#include "body/model_data.h"
#include "body_fixture.h"
#include "mesh_checks.h"
#include "train/population/population.h"

namespace im2fit::lab {
namespace {

class Poses : public WithBody {
 protected:
  void SetUp() override {
    WithBody::SetUp();
    if (IsSkipped()) return;
    rest_.resize(static_cast<std::size_t>(model().vertex_count()));
    model().morph({}, rest_);
    skeleton_ = body::rest_skeleton(model(), rest_);
  }
  JointSet joints(const body::Pose& pose) const {
    std::vector<Vec3f> posed(rest_.size());
    body::skin(model(), rest_, skeleton_, pose, posed);
    return body::joints_of(model(), posed);
  }
  // Degrees between straight down and shoulder to elbow.
  static float abduction(const JointSet& j, Joint shoulder, Joint elbow) {
    const Vec3f d = normalized(j[elbow] - j[shoulder]);
    return std::acos(-d.y) * 57.29578F;
  }
  std::vector<Vec3f> rest_;
  body::Skeleton skeleton_;
};

TEST_F(Poses, RelaxedArmsHangClearOfTheTrunk) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Rng rng(seed);
    const JointSet j = joints(draw_pose(skeleton_, StandingPose::relaxed, rng));
    for (const auto& [s, e] : {std::pair{Joint::LS, Joint::LE}, {Joint::RS, Joint::RE}}) {
      EXPECT_GT(abduction(j, s, e), 7);
      EXPECT_LT(abduction(j, s, e), 33);
    }
    EXPECT_GT(j[Joint::LA].x, j[Joint::LH].x + 120);  // hands outside the hips
    EXPECT_LT(j[Joint::RA].x, j[Joint::RH].x - 120);
    EXPECT_LT(j[Joint::LA].y, j[Joint::LE].y);
  }
}

TEST_F(Poses, PsiArmsAreLevelAndForearmsUp) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Rng rng(seed);
    const JointSet j = joints(draw_pose(skeleton_, StandingPose::psi, rng));
    EXPECT_NEAR(abduction(j, Joint::LS, Joint::LE), 90, 32);
    EXPECT_NEAR(abduction(j, Joint::RS, Joint::RE), 90, 32);
    for (const auto& [e, h] : {std::pair{Joint::LE, Joint::LA}, {Joint::RE, Joint::RA}}) {
      const Vec3f up = normalized(j[h] - j[e]);
      EXPECT_GT(up.y, 0.75F);
    }
  }
}

TEST_F(Poses, CalmPoseIsUprightAndFacesForward) {
  for (const StandingPose pose : {StandingPose::relaxed, StandingPose::a_pose, StandingPose::psi}) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      Rng rng(seed);
      const JointSet j = joints(draw_pose(skeleton_, pose, rng));
      const Vec3f spine = normalized(j[Joint::NE] - (j[Joint::LH] + j[Joint::RH]) * 0.5F);
      EXPECT_GT(spine.y, 0.97F);
      EXPECT_GT(j[Joint::LS].x - j[Joint::RS].x, 250);
      // Both feet near the floor: neither much higher than the other.
      EXPECT_NEAR(j[Joint::LF].y, j[Joint::RF].y, 40);
    }
  }
}

TEST_F(Poses, FreePosesAreWide) {
  float low = 1e9F, high = -1e9F, forward = -1e9F;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Rng rng(seed);
    const JointSet j = joints(draw_pose(skeleton_, StandingPose::free, rng));
    low = std::min(low, j[Joint::LA].y);
    high = std::max(high, j[Joint::LA].y);
    forward = std::max(forward, j[Joint::LA].z);
  }
  EXPECT_GT(high - low, 900);
  EXPECT_GT(forward, 400);
}

// The trunk's lean by its joints: shoulders over hips. Feet stay below the hips.
TEST_F(Poses, BowedTrunksLeanAndLegsStand) {
  int forwards = 0, aside = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Rng rng(seed);
    const JointSet j = joints(draw_pose(skeleton_, StandingPose::bowed, rng));
    const Vec3f hips = (j[Joint::LH] + j[Joint::RH]) * 0.5F;
    const Vec3f path = normalized((j[Joint::LS] + j[Joint::RS]) * 0.5F - hips);
    const float lean_deg = std::acos(path.y) * 57.29578F;
    EXPECT_GT(lean_deg, 12) << seed;
    EXPECT_LT(lean_deg, 62) << seed;
    (path.z > std::fabs(path.x) ? forwards : aside) += 1;
    for (const Joint foot : {Joint::LF, Joint::RF}) {
      EXPECT_NEAR(j[foot].z, hips.z, 200) << seed;
      EXPECT_LT(j[foot].y, hips.y - 600) << seed;
    }
  }
  EXPECT_GT(forwards, 15);
  EXPECT_GT(aside, 15);
}

// By the angle of three joints; both knees alike, before the feet, which stay below the hips.
TEST_F(Poses, SquatsBendBothKneesOverTheFeet) {
  float least = 180, most = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Rng rng(seed);
    const JointSet j = joints(draw_pose(skeleton_, StandingPose::squat, rng));
    const auto bend_deg = [&](Joint hip, Joint knee, Joint foot) {
      return std::acos(dot(normalized(j[knee] - j[hip]), normalized(j[foot] - j[knee]))) * 57.29578F;
    };
    const float left = bend_deg(Joint::LH, Joint::LK, Joint::LF), right = bend_deg(Joint::RH, Joint::RK, Joint::RF);
    EXPECT_NEAR(left, right, 15) << seed;
    least = std::min(least, left);
    most = std::max(most, left);
    EXPECT_GT(j[Joint::LK].z, j[Joint::LF].z + 60) << seed;
    EXPECT_NEAR(j[Joint::LF].z, j[Joint::LH].z, 200) << seed;
  }
  EXPECT_GT(least, 24);
  EXPECT_LT(least, 45);
  EXPECT_GT(most, 85);
}

TEST_F(Poses, SameSeedSamePose) {
  for (const StandingPose pose : {StandingPose::relaxed, StandingPose::free, StandingPose::bowed}) {
    Rng a(4), b(4), c(5);
    const JointSet ja = joints(draw_pose(skeleton_, pose, a)), jb = joints(draw_pose(skeleton_, pose, b)),
                   jc = joints(draw_pose(skeleton_, pose, c));
    EXPECT_EQ(ja[Joint::LA].x, jb[Joint::LA].x);
    EXPECT_NE(ja[Joint::LA].x, jc[Joint::LA].x);
  }
}

TEST_F(Poses, SeatedThighsAreLevelAndShanksUpright) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Rng rng(seed);
    const TrunkShape trunk(model(), rest_, skeleton_);
    const JointSet j = joints(draw_pose(skeleton_, StandingPose::seated, rng, 15, &trunk));
    for (const auto& [h, k, f] : {std::array{Joint::LH, Joint::LK, Joint::LF}, {Joint::RH, Joint::RK, Joint::RF}}) {
      const Vec3f thigh = normalized(j[k] - j[h]), shank = normalized(j[f] - j[k]);
      EXPECT_NEAR(std::asin(thigh.y) * 57.29578F, 0, 12);
      EXPECT_GT(thigh.z, 0.9F);
      EXPECT_LT(std::acos(-shank.y) * 57.29578F, 28);
    }
    EXPECT_GT(j[Joint::HE].y, j[Joint::TO].y + 300);
    EXPECT_NEAR(j[Joint::LF].y, j[Joint::RF].y, 20);  // both feet on the floor
  }
}

// At least one hand on the trunk: nearer than 160 mm to trunk skin (palm and wrist), and neither forearm nor hand
// deeper in the trunk than 35 mm.
TEST_F(Poses, CrossedHandsLieOnTheTrunkNotInIt) {
  const auto skin = model().data().skin;
  const auto segment = [&](std::int32_t v) {
    return static_cast<body::Segment>(skin[static_cast<std::size_t>(v)].segment[0]);
  };
  std::vector<Corner> trunk_triangles;
  for (const Corner& t : model().body_triangles()) {
    bool all = true;
    for (const std::int32_t v : t)
      all = all && (segment(v) == body::Segment::pelvis || segment(v) == body::Segment::abdomen ||
                    segment(v) == body::Segment::chest);
    if (all) trunk_triangles.push_back(t);
  }
  int across = 0, both = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const Subject subject = draw_subject(model(), Family::held_out, 9, seed % 6);
    std::vector<Vec3f> rest(rest_.size()), posed(rest_.size());
    morph_subject(model(), subject, rest);
    const body::Skeleton skeleton = body::rest_skeleton(model(), rest);
    const TrunkShape trunk(model(), rest, skeleton);
    Rng rng(seed);
    body::skin(model(), rest, skeleton, draw_pose(skeleton, StandingPose::crossed, rng, 15, &trunk), posed);
    const JointSet j = body::joints_of(model(), posed);
    int touching = 0;
    for (const Joint hand : {Joint::LA, Joint::RA}) touching += distance_to(j[hand], posed, trunk_triangles) < 160;
    EXPECT_GE(touching, 1) << seed;
    both += touching == 2 ? 1 : 0;
    across += j[Joint::LA].x < 60 || j[Joint::RA].x > -60 ? 1 : 0;
    for (std::int32_t v = 0; v < model().body_vertex_count(); v += 19) {
      const body::Segment s = segment(v);
      if (s != body::Segment::left_lower_arm && s != body::Segment::right_lower_arm &&
          s != body::Segment::left_hand && s != body::Segment::right_hand)
        continue;
      const Vec3f p = posed[static_cast<std::size_t>(v)];
      // The trunk is open where arms, neck and legs go; its solid angle still separates inside from outside.
      if (winding(p, posed, trunk_triangles) > 0.5F) {
        EXPECT_LT(distance_to(p, posed, trunk_triangles), 35) << "seed " << seed << " vertex " << v;
      }
    }
  }
  EXPECT_GT(across, 10);
  EXPECT_GT(both, 8);
}

TEST_F(Poses, StridingSwingsLegsAgainstEachOtherAndComesRound) {
  Rng rng(3);
  const body::Pose standing = draw_pose(skeleton_, StandingPose::relaxed, rng);
  const JointSet still = joints(striding(standing, 0.3F, 0)), start = joints(standing);
  EXPECT_LT(norm(still[Joint::LF] - start[Joint::LF]), 0.01F);
  const JointSet first = joints(striding(standing, 0.25F, 1)), second = joints(striding(standing, 0.75F, 1)),
                 round = joints(striding(standing, 1.25F, 1));
  EXPECT_GT(first[Joint::LF].z - first[Joint::RF].z, 350);
  EXPECT_GT(second[Joint::RF].z - second[Joint::LF].z, 350);
  EXPECT_GT(first[Joint::RA].z, first[Joint::LA].z);  // the arm of the other side goes with the leg
  EXPECT_LT(norm(first[Joint::LF] - round[Joint::LF]), 0.5F);
}

}  // namespace
}  // namespace im2fit::lab
