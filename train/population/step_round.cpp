// SPDX-License-Identifier: Apache-2.0
#include "train/population/step_round.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/rng.h"
#include "train/common/draw.h"
#include "train/render/scene_axes.h"

namespace im2fit::lab {
namespace {

using body::Mat3f;
using body::Segment;

enum Stream : std::uint64_t { kStepRoundStream = 0x5C0A };

constexpr double kDegreesAStep = 45;  // 6 to 10 steps a full turn
constexpr double kUneven = 0.29;      // standard deviation of a step's share, of the mean step
constexpr double kUnevenMin = 0.35;
constexpr float kBreathMm = 3;
constexpr double kWanderLimit = 2.2;  // standard deviations

// What wanders. Sizes by eye of people who step round before a camera; no source has them.
enum Wandering : std::size_t {
  kArmLeft,
  kArmRight,
  kArmForwardLeft,
  kArmForwardRight,
  kElbowLeft,
  kElbowRight,
  kShoulders,
  kSpreadLeft,
  kSpreadRight,
  kKneeLeft,
  kKneeRight,
  kThighLeft,
  kThighRight,
  kSpineForward,
  kSpineSide,
  kSpineTwist,
  kLeanForward,
  kLeanSide,
  kNod,
  kHeadTurn,
  kShiftX,
  kShiftZ,
  kCarryX,
  kCarryZ,
  kWanderingUsed
};
constexpr float kArmDeg = 1.8F, kArmForwardDeg = 2, kElbowDeg = 3, kShouldersDeg = 1, kSpreadDeg = 1.2F, kKneeDeg = 1,
                kSpineDeg = 0.9F, kLeanDeg = 0.8F, kNodDeg = 3, kHeadTurnDeg = 4, kShiftMm = 14, kCarryMm = 70,
                kHoldMm = 8;
constexpr float kSpreadWithLiftDeg = 1.5F, kTwistWithStepDeg = 2.5F, kLeanWithStepDeg = 0.9F, kShiftWithStepMm = 12;

constexpr std::size_t place_of(Segment s) {
  return static_cast<std::size_t>(s);
}

}  // namespace

StepRoundMotion::StepRoundMotion(const StepRound& plan, std::uint64_t seed) : plan_(plan) {
  static_assert(kWanderingUsed <= kWandering);
  Rng rng = Rng::for_item(seed, kStepRoundStream, 0);
  for (auto& waves : waves_)
    for (Wave& w : waves) w = {rng.uniform(0.05, 0.4), rng.uniform()};
  breath_hertz_ = 1 / rng.uniform(3, 4.5);
  breath_phase_ = rng.uniform();
  knee_lift_deg_ = draw(rng, 8, 22);
  lead_share_ = draw(rng, 0.4, 1);
  first_foot_ = static_cast<std::size_t>(rng.index(2));
  const double side = rng.index(2) == 0 ? 1 : -1;
  if (plan.seconds <= 0) return;
  const int usual = std::max(2, static_cast<int>(std::lround(std::fabs(plan.degrees) / kDegreesAStep)));
  const auto count = static_cast<std::size_t>(std::max(2, usual - 2 + rng.index(5)));
  std::vector<double> times(count), angles(count);
  double time_sum = 0, angle_sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    times[i] = std::max(kUnevenMin, 1 + kUneven * rng.normal());
    angles[i] = std::max(kUnevenMin, 1 + kUneven * rng.normal());
    time_sum += times[i];
    angle_sum += angles[i];
  }
  Step step;
  for (std::size_t i = 0; i < count; ++i) {
    step.begin_s = step.end_s;
    step.from_deg = step.to_deg;
    step.end_s += times[i] / time_sum * static_cast<double>(plan.seconds);
    step.to_deg += side * angles[i] / angle_sum * static_cast<double>(plan.degrees);
    steps_.push_back(step);
  }
}

double StepRoundMotion::seconds_at(std::uint64_t frame) const {
  return (static_cast<double>(frame) - plan_.frame_first) / kFramesPerSecond;
}

float StepRoundMotion::wander(std::size_t which, double seconds) const {
  double sum = 0;
  for (const Wave& w : waves_[which]) sum += std::sin(2 * std::numbers::pi * (w.hertz * seconds + w.phase));
  const double value = sum * std::sqrt(2.0 / kWaves);  // of unit variance
  return static_cast<float>(std::clamp(value, -kWanderLimit, kWanderLimit));
}

// Two thirds of a step's angle go by a smooth start and end, the rest evenly.
float StepRoundMotion::yaw_deg(std::uint64_t frame) const {
  const double t = seconds_at(frame);
  double yaw = 0;
  for (const Step& s : steps_) {
    const double u = std::clamp((t - s.begin_s) / (s.end_s - s.begin_s), 0.0, 1.0);
    const double smooth = u - std::sin(2 * std::numbers::pi * u) / (2 * std::numbers::pi);
    yaw += (s.to_deg - s.from_deg) * (0.35 * u + 0.65 * smooth);
  }
  return static_cast<float>(yaw);
}

StepRoundMotion::Stepping StepRoundMotion::stepping(double seconds) const {
  Stepping out;
  if (plan_.camera) return out;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const Step& s = steps_[i];
    const double u = (seconds - s.begin_s) / (s.end_s - s.begin_s);
    if (!(u > 0 && u < 1)) continue;
    const double half = std::sin(std::numbers::pi * u);
    out.lifted[(i + first_foot_) % 2] = static_cast<float>(half * half);
    const double side = s.to_deg > s.from_deg ? 1 : -1;
    out.lead = static_cast<float>(side * std::sin(2 * std::numbers::pi * u));
  }
  return out;
}

Vec3f StepRoundMotion::shift_mm(std::uint64_t frame) const {
  const double t = seconds_at(frame);
  const Stepping step = stepping(t);
  const double yaw = static_cast<double>(yaw_deg(frame)) * std::numbers::pi / 180;
  const float onto = kShiftWithStepMm * (step.lifted[1] - step.lifted[0]);  // the standing foot
  return {kShiftMm * wander(kShiftX, t) * 0.7F + onto * static_cast<float>(std::cos(yaw)), 0,
          kShiftMm * wander(kShiftZ, t) * 0.7F - onto * static_cast<float>(std::sin(yaw))};
}

Rigid StepRoundMotion::carried(std::uint64_t frame) const {
  Rigid out{body::rotation_about(kAxisY, yaw_deg(frame)), {}};
  if (!plan_.camera) return out;
  const double t = seconds_at(frame);
  const auto begun = static_cast<float>(std::clamp(t, 0.0, 1.0));  // a second until the walk is one
  const float size_mm = kHoldMm + (kCarryMm - kHoldMm) * begun;
  out.translation = {size_mm * wander(kCarryX, t), 0, size_mm * wander(kCarryZ, t)};
  return out;
}

float StepRoundMotion::breath_mm(std::uint64_t frame) const {
  return kBreathMm *
         static_cast<float>(std::sin(2 * std::numbers::pi * (breath_hertz_ * seconds_at(frame) + breath_phase_)));
}

body::Pose StepRoundMotion::pose(const body::Pose& standing, std::uint64_t frame) const {
  const double t = seconds_at(frame);
  const Stepping step = stepping(t);
  const auto w = [&](Wandering which, float sd) { return sd * wander(which, t); };
  const auto about = [](Vec3f axis, float degrees) { return body::rotation_about(axis, degrees); };
  std::array<Mat3f, body::kSegmentCount> local{};
  for (std::size_t s = 0; s < local.size(); ++s) {
    const auto parent = body::kSegmentParent[s];
    local[s] = parent < 0 ? standing.rotation[s]
                          : transpose(standing.rotation[static_cast<std::size_t>(parent)]) * standing.rotation[s];
  }
  const auto turn = [&](Segment s, const Mat3f& by) { local[place_of(s)] = by * local[place_of(s)]; };
  const float onto = step.lifted[0] - step.lifted[1];
  turn(Segment::pelvis,
       about(kAxisX, w(kLeanForward, kLeanDeg)) * about(kAxisZ, w(kLeanSide, kLeanDeg) + kLeanWithStepDeg * onto));
  const Mat3f bend = about(kAxisY, (w(kSpineTwist, kSpineDeg) + kTwistWithStepDeg * lead_share_ * step.lead) / 2) *
                     about(kAxisX, w(kSpineForward, kSpineDeg) / 2) * about(kAxisZ, w(kSpineSide, kSpineDeg) / 2);
  turn(Segment::abdomen, bend);
  turn(Segment::chest, bend);
  turn(Segment::neck, about(kAxisX, w(kNod, kNodDeg) / 2) * about(kAxisY, w(kHeadTurn, kHeadTurnDeg) / 2));
  turn(Segment::head, about(kAxisX, w(kNod, kNodDeg) / 2) * about(kAxisY, w(kHeadTurn, kHeadTurnDeg) / 2));
  for (std::size_t i = 0; i < 2; ++i) {
    const auto one = [&](Wandering left) { return static_cast<Wandering>(left + i); };
    const auto limb = [&](Segment left, Segment right) { return i == 0 ? left : right; };
    const float side = i == 0 ? 1.0F : -1.0F;
    turn(limb(Segment::left_shoulder, Segment::right_shoulder), about(kAxisZ, side * w(kShoulders, kShouldersDeg)));
    turn(limb(Segment::left_upper_arm, Segment::right_upper_arm),
         about(kAxisX, -w(one(kArmForwardLeft), kArmForwardDeg)) * about(kAxisZ, side * w(one(kArmLeft), kArmDeg)));
    turn(limb(Segment::left_lower_arm, Segment::right_lower_arm), about(kAxisX, -w(one(kElbowLeft), kElbowDeg)));
    const float knee = std::max(0.0F, w(one(kKneeLeft), kKneeDeg) + knee_lift_deg_ * step.lifted[i]);
    const float thigh = knee / 2 + w(one(kThighLeft), kKneeDeg);
    const float spread = w(one(kSpreadLeft), kSpreadDeg) + kSpreadWithLiftDeg * step.lifted[i];
    turn(limb(Segment::left_upper_leg, Segment::right_upper_leg),
         about(kAxisX, -thigh) * about(kAxisZ, side * spread));
    turn(limb(Segment::left_lower_leg, Segment::right_lower_leg), about(kAxisX, knee));
    // The foot stays level.
    turn(limb(Segment::left_foot, Segment::right_foot), about(kAxisX, thigh - knee));
  }
  return body::pose_from_local(local, standing.translation_mm);
}

}  // namespace im2fit::lab
