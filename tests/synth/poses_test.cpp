// SPDX-License-Identifier: Apache-2.0
#include "synth/poses.h"

#include <cmath>
#include <vector>

#include "body_fixture.h"
#include "synth/population.h"

namespace im2fit::synth {
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

TEST_F(Poses, SameSeedSamePose) {
  for (const StandingPose pose : {StandingPose::relaxed, StandingPose::free}) {
    Rng a(4), b(4), c(5);
    const JointSet ja = joints(draw_pose(skeleton_, pose, a)), jb = joints(draw_pose(skeleton_, pose, b)),
                   jc = joints(draw_pose(skeleton_, pose, c));
    EXPECT_EQ(ja[Joint::LA].x, jb[Joint::LA].x);
    EXPECT_NE(ja[Joint::LA].x, jc[Joint::LA].x);
  }
}

}  // namespace
}  // namespace im2fit::synth
