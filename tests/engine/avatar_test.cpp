// SPDX-License-Identifier: Apache-2.0
#include "person/avatar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "body/measure.h"
#include "fake_stages.h"

namespace im2fit {
namespace {

// The camera looks down by `pitch` at people standing on the floor 900 mm below it.
FloorPlane floor_below(double pitch_rad) {
  FloorPlane floor;
  floor.known = true;
  floor.up = {0, static_cast<float>(-std::cos(pitch_rad)), static_cast<float>(-std::sin(pitch_rad))};
  floor.camera_height_mm = 900;
  return floor;
}

// World (x right, y up from the floor, z away from the camera) to camera axes by textbook trigonometry.
Vec3f to_camera(Vec3f world, double pitch_rad) {
  const double y = static_cast<double>(world.y) - 900;
  const double z = static_cast<double>(world.z);
  const double c = std::cos(pitch_rad);
  const double s = std::sin(pitch_rad);
  return {world.x, static_cast<float>(-c * y - s * z), static_cast<float>(-s * y + c * z)};
}

TEST(ToMeshAxes, LevelsATiltedCameraAndPutsTheFloorAtZero) {
  for (const double pitch : {0.0, 0.2, -0.15}) {
    const Vec3f head{40, 1600, 2300};
    const Vec3f left_hip{90, 920, 2310};
    const Vec3f right_hip{-90, 920, 2290};
    const Vec3f left_hand{300, 800, 2250};
    JointSet joints;
    joints[Joint::HE] = to_camera(head, pitch);
    joints[Joint::LH] = to_camera(left_hip, pitch);
    joints[Joint::RH] = to_camera(right_hip, pitch);
    joints[Joint::LA] = to_camera(left_hand, pitch);
    const JointSet mesh = to_mesh_axes(joints, floor_below(pitch));
    // Mesh z is out of the face: towards the camera. Hips' middle (0, 920, 2300).
    EXPECT_NEAR(mesh[Joint::HE].x, 40, 0.01);
    EXPECT_NEAR(mesh[Joint::HE].y, 1600, 0.01);
    EXPECT_NEAR(mesh[Joint::HE].z, 0, 0.01);
    EXPECT_NEAR(mesh[Joint::LA].x, 300, 0.01) << "the person's left is +x";
    EXPECT_NEAR(mesh[Joint::LA].z, 50, 0.01) << "a hand held forward is +z";
    EXPECT_NEAR(mesh[Joint::LH].y, 920, 0.01);
  }
}

TEST(ToMeshAxes, WithoutAFloorTheHipsAreTheOrigin) {
  JointSet joints;
  joints[Joint::LH] = {90, 100, 2000};
  joints[Joint::RH] = {-90, 100, 2000};
  joints[Joint::NE] = {0, -400, 2000};
  const JointSet mesh = to_mesh_axes(joints, {});
  EXPECT_FLOAT_EQ(mesh[Joint::NE].y, 500);
  EXPECT_FLOAT_EQ(mesh[Joint::LH].x, 90);
  EXPECT_FLOAT_EQ(mesh[Joint::LH].y, 0);
}

std::string body_path() {
  if (const char* path = std::getenv("IM2FIT_BODY")) return path;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  return cache != nullptr ? std::string(cache) + "/im2fit/body.i2b"
                          : std::string(home != nullptr ? home : "") + "/.cache/im2fit/body.i2b";
}

body::MeasurementGoals well_known(const MeasurementValues& values) {
  body::MeasurementGoals goals;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) goals[i] = {values[i], 5};
  return goals;
}

class BodyOfGoals : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::ifstream(body_path())) GTEST_SKIP() << "no body file at " << body_path() << ": run im2fit-lab fetch";
    auto loaded = body::BodyModel::load(body_path());
    ASSERT_TRUE(loaded) << loaded.error().message;
    model_.emplace(std::move(*loaded));
  }
  std::optional<body::BodyModel> model_;
};

TEST_F(BodyOfGoals, MeasuresWhatIsAnsweredAndStandsAsMeasured) {
  body::Params someone;
  someone.gender = 1;
  someone.age_years = 40;
  someone.modifiers.assign(model_->modifier_names().size(), 0.0F);

  // Truth of the pose: the joints of a mesh posed with the arms out, seen by a camera pitched by 0.1.
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model_->vertex_count()));
  body::Params same = someone;
  same.height = 0.6F;
  same.weight = 0.55F;
  model_->morph(same, mesh);
  const auto rest = body::rest_skeleton(*model_, mesh);
  std::vector<Vec3f> posed(mesh.size());
  body::skin(*model_, mesh, rest, body::psi_pose(rest), posed);
  const JointSet truth = body::joints_of(*model_, posed);
  const double pitch = 0.1;
  JointSet seen = truth;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const Vec3f p = truth.position_mm[i];
    seen.position_mm[i] = to_camera({p.x, p.y, 2400 - p.z}, pitch);
  }

  // Of another person: taller, heavier, broader round the waist.
  MeasurementValues wanted = body::measure_person(*model_, same);
  wanted[measurement_index(Measurement::stature)] += 30;
  wanted[measurement_index(Measurement::waist_girth)] += 25;
  wanted[measurement_index(Measurement::weight)] += 4;
  body::MeasurementFitter fitter(*model_);
  const auto answered = body_of_goals(fitter, someone, well_known(wanted), seen, floor_below(pitch));
  ASSERT_TRUE(answered) << answered.error().message;
  model_->morph(answered->params, mesh);
  const MeasurementValues values = body::measure_rest_mesh(*model_, mesh, answered->params.gender);
  EXPECT_EQ(values, answered->fit.values);
  EXPECT_EQ(values, fitter.measured().values());
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    EXPECT_NEAR(values[i], wanted[i], 0.5) << kMeasurementTable[i].id;

  body::skin(*model_, mesh, body::rest_skeleton(*model_, mesh), answered->pose, posed);
  const JointSet again = body::joints_of(*model_, posed);
  const Vec3f hips = (truth[Joint::LH] + truth[Joint::RH]) * 0.5F;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const Vec3f error = again.position_mm[i] - (truth.position_mm[i] - Vec3f{hips.x, 0, hips.z});
    EXPECT_LT(norm(error), 40) << kJointNames[i];  // the body is 30 mm taller than the one seen
  }
}

TEST_F(BodyOfGoals, BeyondTheModelGivesTheNearestAndSaysHowFar) {
  MeasurementValues wanted = body::measure_person(*model_, {});
  wanted[measurement_index(Measurement::chest_girth)] = 300;
  body::MeasurementFitter fitter(*model_);
  const auto answered = body_of_goals(fitter, {}, well_known(wanted), test::standing_joints(false), {});
  ASSERT_TRUE(answered);
  EXPECT_EQ(fitter.measured().values(), answered->fit.values);  // of the nearest, whichever step found it
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model_->vertex_count()));
  model_->morph(answered->params, mesh);
  ASSERT_EQ(answered->rest.size(), mesh.size());
  for (std::size_t v = 0; v < mesh.size(); ++v) ASSERT_EQ(norm(answered->rest[v] - mesh[v]), 0) << "vertex " << v;
  EXPECT_GT(body::girth_residual_mm(answered->fit.residual), 20);
}

// A 95 % interval is 3.92 standard deviations of a normal distribution.
TEST(GoalsOf, TakesTheIntervalsAsHowWellValuesAreKnown) {
  index::Answer answer;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) answer.measurements[i] = {1000, 980.4F, 1019.6F};
  for (const body::MeasurementGoal& goal : goals_of(answer)) {
    EXPECT_EQ(goal.value, 1000);
    EXPECT_NEAR(goal.sd, 10, 1e-3);
  }
}

TEST_F(BodyOfGoals, RefusesOddNumbers) {
  const JointSet joints = test::standing_joints(false);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  MeasurementValues wanted = body::measure_person(*model_, {});
  const body::MeasurementGoals sound = well_known(wanted);
  body::MeasurementFitter fitter(*model_);
  for (const float bad : {nan, 0.0F, -5.0F}) {
    wanted[measurement_index(Measurement::hip_girth)] = bad;
    const auto refused = body_of_goals(fitter, {}, well_known(wanted), joints, {});
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, testing::HasSubstr("hip_girth"));
  }
  JointSet odd = joints;
  odd[Joint::LK].z = nan;
  const auto answered = body_of_goals(fitter, {}, sound, odd, {});
  ASSERT_FALSE(answered);
  EXPECT_THAT(answered.error().message, testing::HasSubstr("LK"));
}

}  // namespace
}  // namespace im2fit
