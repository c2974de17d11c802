// SPDX-License-Identifier: Apache-2.0
// The filters of displayed joints against closed forms: steps, ramps, noise of known variance, a chain of known
// bones.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/rng.h"
#include "perception/observe/chain_filter.h"
#include "perception/observe/joint_filter.h"
#include "perception/observe/motion_filter.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit {
namespace {

constexpr float kPeriod = 1.0F / 30.0F;
constexpr double kPi = 3.14159265358979323846;

JointSet all_at(Vec3f p, float confidence = 0.9F) {
  JointSet joints;
  joints.position_mm.fill(p);
  joints.confidence.fill(confidence);
  return joints;
}

JointFilterSettings plain(float cutoff_hz) {
  JointFilterSettings settings;
  settings.min_cutoff_hz = cutoff_hz;
  settings.beta_hz_s_per_mm = 0;
  return settings;
}

// Share of the new sample, by the definition tau = 1/(2 pi fc), alpha = 1/(1 + tau/T).
double share(double cutoff_hz, double period_s) {
  return 1 / (1 + 1 / (2 * kPi * cutoff_hz * period_s));
}

TEST(JointFilter, AStepIsApproachedGeometrically) {
  const double a = share(2, 1.0 / 30);
  JointFilter filter(plain(2));
  filter.step(all_at({0, 0, 2000}), kPeriod);
  double left = 100;
  for (int i = 0; i < 40; ++i) {
    left *= 1 - a;
    const JointSet out = filter.step(all_at({100, 0, 2000}), kPeriod);
    EXPECT_NEAR(out[Joint::LA].x, 100 - left, 0.002) << i;
    EXPECT_EQ(out[Joint::LA].z, 2000.0F);
    EXPECT_EQ(out.confidence[0], 0.9F);
  }
}

TEST(JointFilter, ARampLagsByWhatIsStatedAtAnyRateAndSpeed) {
  const JointFilterSettings settings;
  for (const float rate_hz : {15.0F, 30.0F, 60.0F})
    for (const float speed : {0.0F, 100.0F, 360.0F, 1000.0F, 2000.0F}) {
      JointFilter filter(settings);
      JointSet out;
      float x = 0;
      for (int i = 0; i < 200; ++i) {
        x = speed / rate_hz * static_cast<float>(i);
        out = filter.step(all_at({x, 0, 2000}), 1 / rate_hz);
      }
      const double lag_mm = static_cast<double>(x - out[Joint::TO].x);
      const double stated_ms = static_cast<double>(joint_filter_lag_ms(settings, speed));
      EXPECT_NEAR(lag_mm, static_cast<double>(speed) * stated_ms * 1e-3,
                  0.01 * static_cast<double>(speed) * 0.02 + 0.05)
          << speed << " mm/s at " << rate_hz;
    }
  // The figures of the header.
  EXPECT_NEAR(joint_filter_lag_ms(settings, 0), 106, 0.5);
  EXPECT_NEAR(joint_filter_lag_ms(settings, 360), 40, 0.5);
  EXPECT_NEAR(joint_filter_lag_ms(settings, 1000), 19, 0.5);
  EXPECT_NEAR(joint_filter_lag_ms(settings, 2000), 10, 0.5);
}

TEST(JointFilter, NoiseShrinksAsALowPassShrinksIt) {
  // A first-order low-pass of share a keeps a/(2-a) of white noise's variance.
  const double a = share(1.5, 1.0 / 30);
  JointFilter filter(plain(1.5F));
  Rng rng(5);
  double in = 0;
  double out = 0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const auto noise = static_cast<float>(rng.normal(0, 8));
    const double filtered = static_cast<double>(filter.step(all_at({noise, 0, 2000}), kPeriod)[Joint::HE].x);
    if (i < 100) continue;
    in += static_cast<double>(noise) * static_cast<double>(noise);
    out += filtered * filtered;
  }
  EXPECT_NEAR(out / in, a / (2 - a), 0.01);
}

TEST(JointFilter, AJumpAGapAndALossStartAnew) {
  JointFilter filter;
  for (int i = 0; i < 10; ++i) filter.step(all_at({0, 0, 2000}), kPeriod);
  JointSet one = all_at({0, 0, 2000});
  one[Joint::LA].x = 301;
  const JointSet jumped = filter.step(one, kPeriod);
  EXPECT_EQ(jumped[Joint::LA].x, 301.0F) << "further than any hand in a frame";
  EXPECT_EQ(jumped[Joint::RA].x, 0.0F);
  EXPECT_LT(filter.step(all_at({299, 0, 2000}), kPeriod)[Joint::RA].x, 299.0F) << "fast, but a movement";

  EXPECT_EQ(filter.step(all_at({200, 0, 2000}), 0.6F)[Joint::RA].x, 200.0F) << "nothing seen for too long";
  EXPECT_EQ(filter.step(all_at({210, 0, 2000}), 0)[Joint::RA].x, 210.0F) << "no time at all";
  filter.reset();
  EXPECT_EQ(filter.step(all_at({220, 0, 2000}), kPeriod)[Joint::RA].x, 220.0F);
}

TEST(JointFilter, WhatIsNoNumberPassesAndIsForgotten) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  JointFilter filter;
  filter.step(all_at({0, 0, 2000}), kPeriod);
  EXPECT_TRUE(std::isnan(filter.step(all_at({kNaN, 0, 2000}), kPeriod)[Joint::HE].x));
  EXPECT_EQ(filter.step(all_at({5, 0, 2000}), kPeriod)[Joint::HE].x, 5.0F);
  EXPECT_LT(filter.step(all_at({9, 0, 2000}), kPeriod)[Joint::HE].x, 9.0F);
}

JointSet figure(float x_mm = 0) {
  return test::standing_figure(x_mm, 2300).joints;
}

TEST(ChainFilter, WhatIsSeenPassesUnchanged) {
  ChainFilter chain;
  for (int i = 0; i < 3; ++i) {
    const JointSet joints = figure(static_cast<float>(10 * i));
    const ChainedJoints out = chain.step(joints, kPeriod);
    EXPECT_EQ(out.inferred, 0U);
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_EQ(norm(out.joints.position_mm[j] - joints.position_mm[j]), 0);
  }
}

TEST(ChainFilter, AHiddenForearmTravelsWithItsElbow) {
  ChainFilter chain;
  chain.step(figure(), kPeriod);
  const Vec3f bone = figure()[Joint::LA] - figure()[Joint::LE];
  JointSet hidden = figure(150);
  hidden[Joint::LA] = {0, 0, 1700};  // the tracker's guess is on the belly
  hidden.confidence[joint_index(Joint::LA)] = 0.1F;
  const ChainedJoints out = chain.step(hidden, kPeriod);
  EXPECT_EQ(out.inferred, joint_bit(joint_index(Joint::LA)));
  EXPECT_NEAR(norm(out.joints[Joint::LA] - (hidden[Joint::LE] + bone)), 0, 0.01);
  EXPECT_EQ(out.joints.confidence[joint_index(Joint::LA)], 0.1F) << "the confidence says how sure";
}

TEST(ChainFilter, AHiddenLegHangsTogether) {
  ChainFilter chain;
  chain.step(figure(), kPeriod);
  JointSet cut = figure(-80);
  for (const Joint joint : {Joint::RK, Joint::RF}) {
    cut[joint] = {500, 500, 3000};
    cut.confidence[joint_index(joint)] = 0.05F;
  }
  const ChainedJoints out = chain.step(cut, kPeriod);
  EXPECT_EQ(out.inferred, joint_bit(joint_index(Joint::RK)) | joint_bit(joint_index(Joint::RF)));
  EXPECT_NEAR(norm(out.joints[Joint::RK] - figure(-80)[Joint::RK]), 0, 0.01);
  EXPECT_NEAR(norm(out.joints[Joint::RF] - figure(-80)[Joint::RF]), 0, 0.01);
}

TEST(ChainFilter, AfterASecondTheDirectionIsTheTrackersAndTheLengthTheBones) {
  ChainFilter chain;
  chain.step(figure(), kPeriod);
  const float length = norm(figure()[Joint::LF] - figure()[Joint::LK]);
  JointSet hidden = figure();
  hidden[Joint::LF] = hidden[Joint::LK] + Vec3f{0, 0, -900};
  hidden.confidence[joint_index(Joint::LF)] = 0;
  ChainedJoints out;
  for (int i = 0; i < 29; ++i) out = chain.step(hidden, kPeriod);
  EXPECT_NEAR(norm(out.joints[Joint::LF] - figure()[Joint::LF]), 0, 0.01);
  for (int i = 0; i < 3; ++i) out = chain.step(hidden, kPeriod);
  EXPECT_NEAR(norm(out.joints[Joint::LF] - (hidden[Joint::LK] + Vec3f{0, 0, -length})), 0, 0.01);
}

TEST(ChainFilter, ABoneNeverSeenIsAsLongAsItsMirrorImage) {
  ChainFilter chain;
  JointSet joints = figure();
  joints.confidence[joint_index(Joint::RA)] = 0;
  joints[Joint::RA] = joints[Joint::RE] + Vec3f{-10, 30, 0};
  chain.step(joints, kPeriod);  // the left arm is learned after the right one in the first frame
  const ChainedJoints out = chain.step(joints, kPeriod);
  const float length = norm(figure()[Joint::LA] - figure()[Joint::LE]);
  const Vec3f along = normalized(Vec3f{-10, 30, 0});
  EXPECT_NEAR(norm(out.joints[Joint::RA] - (joints[Joint::RE] + along * length)), 0, 0.01);
}

// The elbow is a guess, and far off: the span between it and the hand is not a forearm.
TEST(ChainFilter, ABoneIsNotLearnedFromAGuessedParent) {
  ChainFilter chain;
  chain.step(figure(), kPeriod);
  const Vec3f bone = figure()[Joint::LA] - figure()[Joint::LE];
  JointSet guessed = figure();
  guessed[Joint::LE] = guessed[Joint::LA] + Vec3f{0, 0, 900};
  guessed.confidence[joint_index(Joint::LE)] = 0.1F;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(chain.step(guessed, kPeriod).inferred, joint_bit(joint_index(Joint::LE)));
  JointSet hidden = figure(100);
  hidden.confidence[joint_index(Joint::LA)] = 0.1F;
  const ChainedJoints out = chain.step(hidden, kPeriod);
  EXPECT_NEAR(norm(out.joints[Joint::LA] - (hidden[Joint::LE] + bone)), 0, 0.01);
}

TEST(ChainFilter, WithNothingKnownTheTrackersGuessStandsAndIsMarked) {
  ChainFilter chain;
  JointSet joints = figure();
  joints.confidence.fill(0);
  const ChainedJoints out = chain.step(joints, kPeriod);
  EXPECT_EQ(out.inferred, 0x7FFFU & ~joint_bit(joint_index(Joint::TO)));
  for (std::size_t j = 0; j < kJointCount; ++j) EXPECT_EQ(norm(out.joints.position_mm[j] - joints.position_mm[j]), 0);
}

TEST(MotionFilter, StatesTheSpeedOfARamp) {
  for (const float speed : {20.0F, 80.0F, 1000.0F})
    for (const float rate_hz : {15.0F, 30.0F}) {
      MotionFilter filter;
      Motion motion;
      for (int i = 0; i < 40; ++i) {
        const float x = speed / rate_hz * static_cast<float>(i);
        motion = filter.step({x, 0, 2300}, figure(x), 1 / rate_hz);
        if (i < MotionFilter::kFrameCount - 1) {
          EXPECT_EQ(motion.body_mm_s, 0.0F) << "too early to say";
        }
      }
      EXPECT_NEAR(motion.body_mm_s, speed, 0.005F * speed);
      EXPECT_NEAR(motion.limb_mm_s, speed, 0.005F * speed);
    }
}

TEST(MotionFilter, AWavingHandIsALimb) {
  MotionFilter filter;
  Motion motion;
  for (int i = 0; i < 20; ++i) {
    JointSet joints = figure();
    joints[Joint::RA].y -= 10.0F * static_cast<float>(i);  // 300 mm/s
    motion = filter.step({0, 0, 2300}, joints, kPeriod);
  }
  EXPECT_EQ(motion.body_mm_s, 0.0F);
  EXPECT_NEAR(motion.limb_mm_s, 300, 1);
}

TEST(MotionFilter, TremorIsNoMovement) {
  MotionFilter filter;
  Rng rng(3);
  double sum2 = 0;
  constexpr int kCount = 4000;
  for (int i = 0; i < kCount; ++i) {
    const auto tremor = static_cast<float>(rng.normal(0, 5));  // stated: 1.9 x 5 mm/s
    const double v = static_cast<double>(filter.step({tremor, 0, 2300}, figure(), kPeriod).body_mm_s);
    sum2 += v * v;
  }
  EXPECT_NEAR(std::sqrt(sum2 / kCount), 1.875 * 5, 0.5);
}

TEST(MotionFilter, UnseenAndJumpingLimbsAreIgnored) {
  MotionFilter unseen;
  MotionFilter jumping;
  for (int i = 0; i < 20; ++i) {
    JointSet joints = figure();
    joints[Joint::LF].x += 20.0F * static_cast<float>(i);
    joints.confidence[joint_index(Joint::LF)] = 0.1F;
    EXPECT_EQ(unseen.step({}, joints, kPeriod).limb_mm_s, 0.0F);
    joints = figure();
    joints[Joint::LA].x += i % 2 == 0 ? 0.0F : 400.0F;
    EXPECT_EQ(jumping.step({}, joints, kPeriod).limb_mm_s, 0.0F);
  }
}

TEST(MotionFilter, ALossForgets) {
  MotionFilter filter;
  for (int i = 0; i < 20; ++i) filter.step({30.0F * static_cast<float>(i), 0, 0}, figure(), kPeriod);
  filter.reset();
  for (int i = 0; i < MotionFilter::kFrameCount - 1; ++i)
    EXPECT_EQ(filter.step({30.0F * static_cast<float>(i), 0, 0}, figure(), kPeriod).body_mm_s, 0.0F);
}

}  // namespace
}  // namespace im2fit
