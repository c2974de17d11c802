// SPDX-License-Identifier: Apache-2.0
// How people move who stand, step round on the spot and stand again: uneven steps with lifted feet, a trunk that
// sways, arms that wander, breath. Or who stand still while a camera is carried round them. Any frame can be had
// without the ones before it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "body/skeleton.h"
#include "core/vec3.h"
#include "train/render/scene_axes.h"

namespace im2fit::lab {

// How long people take who are asked to turn once, slowly.
inline constexpr float kStepRoundSecondsMin = 6, kStepRoundSecondsMax = 15;
// How long people take who walk round another with a camera.
inline constexpr float kWalkRoundSecondsMin = 10, kWalkRoundSecondsMax = 30;

struct StepRound {
  int frame_first = 0;  // of the first step
  float seconds = 0;    // of the whole turn; 0: never turns
  float degrees = 360;  // of the whole turn, to a side that the seed draws
  bool camera = false;  // the person stands; the camera is carried round
};

// 6 to 10 steps a full turn, to 20 % and more uneven in time and angle.
class StepRoundMotion {
 public:
  StepRoundMotion() = default;
  StepRoundMotion(const StepRound& plan, std::uint64_t seed);

  // Of the person's first stance; + to the person's left. As the camera sees it.
  float yaw_deg(std::uint64_t frame) const;
  // Of the pelvis over the floor, mm: at most 43. In axes in which the person faced +z before the turn.
  Vec3f shift_mm(std::uint64_t frame) const;
  // With StepRound::camera, how the world moves before the camera: about the person, and nearer, farther and aside by
  // at most 160 mm, for nobody walks a circle. Else the turn alone.
  Rigid carried(std::uint64_t frame) const;
  // The chest's front moves so far forwards: breath, at most 3 mm.
  float breath_mm(std::uint64_t frame) const;
  // The pose drawn for standing, in motion.
  body::Pose pose(const body::Pose& standing, std::uint64_t frame) const;

 private:
  struct Step {
    double begin_s = 0, end_s = 0;  // since frame_first
    double from_deg = 0, to_deg = 0;
  };
  // Of a smooth noise of unit standard deviation, 0.05 to 0.4 Hz.
  struct Wave {
    double hertz = 0, phase = 0;
  };
  static constexpr std::size_t kWandering = 24, kWaves = 4;

  double seconds_at(std::uint64_t frame) const;
  float wander(std::size_t which, double seconds) const;
  struct Stepping {
    std::array<float, 2> lifted{};  // 0..1, left and right
    float lead = 0;                 // -1..1: the trunk goes before the feet
  };
  Stepping stepping(double seconds) const;

  StepRound plan_;
  std::vector<Step> steps_;
  std::array<std::array<Wave, kWaves>, kWandering> waves_{};
  double breath_hertz_ = 0.27, breath_phase_ = 0;
  float knee_lift_deg_ = 15, lead_share_ = 0.7F;
  std::size_t first_foot_ = 0;
};

}  // namespace im2fit::lab
