// SPDX-License-Identifier: Apache-2.0
// How far the trunk reaches from its axis, so that posed hands lie on it and not in it. Rest axes.
#pragma once

#include <array>
#include <span>

#include "body/model.h"
#include "body/skeleton.h"

namespace im2fit::lab {

// Radius by height and by direction about the upright axis through the middle of the trunk.
class TrunkShape {
 public:
  TrunkShape(const body::BodyModel& model, std::span<const Vec3f> rest, const body::Skeleton& skeleton);
  // `up`: 0 at the hips' height, 1 at the shoulders'; `angle_deg`: 0 front, 90 the person's left. A point on the skin
  // plus `clear_mm` outwards.
  Vec3f point(float up, float angle_deg, float clear_mm) const;
  // How far inside the trunk, mm; negative outside (then not the distance: along the ray from the axis), -1000 above
  // the shoulders or below the hips.
  float depth_inside(Vec3f p) const;
  float thigh_radius_mm() const { return thigh_radius_mm_; }

 private:
  static constexpr int kLevels = 24, kSectors = 36;
  float radius(float up, float angle_deg) const;
  std::array<std::array<float, kSectors>, kLevels> radius_{};
  Vec3f axis_;  // at the hips' height
  float hips_y_ = 0, shoulders_y_ = 0, thigh_radius_mm_ = 80;
};

}  // namespace im2fit::lab
