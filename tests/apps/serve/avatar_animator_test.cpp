// SPDX-License-Identifier: Apache-2.0
// Against meshes whose joints are known.
#include "apps/kiosk/avatar_animator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "data_paths.h"

namespace im2fit::apps {
namespace {

class AvatarAnimators : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(test::body_path())) GTEST_SKIP() << "no body file: run im2fit-lab fetch";
    auto loaded = body::BodyModel::load(test::body_path());
    ASSERT_TRUE(loaded) << loaded.error().message;
    model_ = std::make_unique<body::BodyModel>(std::move(*loaded));
    params_.gender = 1;
    params_.age_years = 40;
    rest_.resize(static_cast<std::size_t>(model_->vertex_count()));
    model_->morph(params_, rest_);
    skeleton_ = body::rest_skeleton(*model_, rest_);
  }
  std::vector<Vec3f> skinned(const body::Pose& pose) const {
    std::vector<Vec3f> mesh(rest_.size());
    body::skin(*model_, rest_, skeleton_, pose, mesh);
    return mesh;
  }
  float lowest(const std::vector<Vec3f>& mesh) const {
    float low = mesh[0].y;
    for (int v = 0; v < model_->body_vertex_count(); ++v) low = std::min(low, mesh[static_cast<std::size_t>(v)].y);
    return low;
  }
  std::unique_ptr<body::BodyModel> model_;
  body::Params params_;
  std::vector<Vec3f> rest_;
  body::Skeleton skeleton_;
};

// Quaternion to matrix, Hamilton's product written out.
body::Mat3f matrix(const std::array<float, 4>& q) {
  const float x = q[0], y = q[1], z = q[2], w = q[3];
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w),
           1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w),
           1 - 2 * (x * x + y * y)}};
}

// A person in a known pose before a camera a metre above the floor: the animator of the same body stands where they
// do, but for the distance from the camera.
TEST_F(AvatarAnimators, StandsAsTheJointsSay) {
  for (const body::Pose& pose :
       {body::psi_pose(skeleton_), body::relaxed_pose(skeleton_, 15), body::a_pose(skeleton_)}) {
    std::vector<Vec3f> mesh = skinned(pose);
    const float low = lowest(mesh);
    for (Vec3f& v : mesh) v.y -= low;
    const JointSet truth = body::joints_of(*model_, mesh);
    constexpr float kCameraHeightMm = 1000;
    JointSet seen = truth;  // x right, y down, z forward
    for (Vec3f& p : seen.position_mm) p = {p.x + 150, kCameraHeightMm - p.y, 2300 - p.z};
    const FloorPlane floor{true, {0, -1, 0}, kCameraHeightMm};

    const auto animator = AvatarAnimator::create({model_.get(), params_, pose});
    ASSERT_TRUE(animator) << animator.error().message;
    const body::RigPose rig = animator->rig(animator->pose(seen, floor));
    std::array<body::Mat3f, body::kSegmentCount> local;
    for (std::size_t s = 0; s < local.size(); ++s) local[s] = matrix(rig.rotation[s]);
    const std::vector<Vec3f> stood = skinned(body::pose_from_local(local, rig.root_m * 1000.0F - skeleton_.head[0]));
    EXPECT_NEAR(lowest(stood), 0, 8);
    const JointSet joints = body::joints_of(*model_, stood);
    const Vec3f hips = (truth[Joint::LH] + truth[Joint::RH]) * 0.5F;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const Vec3f off = joints.position_mm[j] - (truth.position_mm[j] - Vec3f{hips.x, 0, hips.z});
      EXPECT_LT(std::sqrt(dot(off, off)), 25) << kJointNames[j];
    }
    const auto shown = standing_joints_m(seen, floor);
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_NEAR(shown[j].y, truth.position_mm[j].y / 1000, 1e-4) << kJointNames[j];
  }
}

TEST_F(AvatarAnimators, StandsOnTheFloorThatIsNotSeen) {
  const JointSet truth = body::joints_of(*model_, skinned(body::relaxed_pose(skeleton_, 15)));
  JointSet seen = truth;
  for (Vec3f& p : seen.position_mm) p = {p.x, -p.y, 2300 - p.z};
  const auto shown = standing_joints_m(seen, {});
  float low = 1;
  for (const Vec3f& p : shown) low = std::min(low, p.y);
  EXPECT_NEAR(low, 0.08F, 1e-4F);
}

}  // namespace
}  // namespace im2fit::apps
