// SPDX-License-Identifier: Apache-2.0
#include "train/population/trunk_shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "body/model_data.h"

namespace im2fit::lab {
namespace {

using body::Segment;
constexpr float kDegrees = 180 / std::numbers::pi_v<float>;

bool of_trunk(Segment s) {
  return s == Segment::pelvis || s == Segment::abdomen || s == Segment::chest;
}

}  // namespace

TrunkShape::TrunkShape(const body::BodyModel& model, std::span<const Vec3f> rest, const body::Skeleton& skeleton) {
  const auto head = [&](Segment s) { return skeleton.head[static_cast<std::size_t>(s)]; };
  const auto tail = [&](Segment s) { return skeleton.tail[static_cast<std::size_t>(s)]; };
  const Vec3f hips = (head(Segment::left_upper_leg) + head(Segment::right_upper_leg)) * 0.5F;
  const Vec3f shoulders = (head(Segment::left_upper_arm) + head(Segment::right_upper_arm)) * 0.5F;
  hips_y_ = hips.y;
  shoulders_y_ = shoulders.y;
  axis_ = {hips.x, hips.y, (hips.z + shoulders.z) / 2};
  const Vec3f thigh = head(Segment::left_upper_leg);
  const Vec3f knee = tail(Segment::left_upper_leg);
  float thigh_sum = 0;
  int thigh_count = 0;
  const auto skin = model.data().skin;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model.body_vertex_count()); ++i) {
    const Vec3f p = rest[i];
    const auto segment = static_cast<Segment>(skin[i].segment[0]);
    if (segment == Segment::left_upper_leg) {
      const float t = dot(p - thigh, knee - thigh) / dot(knee - thigh, knee - thigh);
      if (t > 0.45F && t < 0.7F) {
        thigh_sum += norm(p - (thigh + (knee - thigh) * t));
        ++thigh_count;
      }
    }
    if (!of_trunk(segment)) continue;
    const float up = (p.y - hips_y_) / (shoulders_y_ - hips_y_);
    const int level = static_cast<int>(std::floor(up * kLevels));
    const float angle = std::atan2(p.x - axis_.x, p.z - axis_.z) * kDegrees;
    const int sector = static_cast<int>(std::floor(angle / (360.0F / kSectors) + kSectors)) % kSectors;
    const float r = std::hypot(p.x - axis_.x, p.z - axis_.z);
    // Vertices are up to a level apart: each counts for its neighbours too.
    for (int near = std::max(0, level - 1); near <= std::min(kLevels - 1, level + 1); ++near) {
      for (int ds = -1; ds <= 1; ++ds) {
        const auto at = static_cast<std::size_t>((sector + ds + kSectors) % kSectors);
        float& most = radius_[static_cast<std::size_t>(near)][at];
        most = std::max(most, r);
      }
    }
  }
  if (thigh_count > 0) thigh_radius_mm_ = thigh_sum / static_cast<float>(thigh_count);
}

float TrunkShape::radius(float up, float angle_deg) const {
  const int level = std::clamp(static_cast<int>(std::floor(up * kLevels)), 0, kLevels - 1);
  const int sector = static_cast<int>(std::floor(angle_deg / (360.0F / kSectors) + 2 * kSectors)) % kSectors;
  return radius_[static_cast<std::size_t>(level)][static_cast<std::size_t>(sector)];
}

Vec3f TrunkShape::point(float up, float angle_deg, float clear_mm) const {
  const float r = radius(up, angle_deg) + clear_mm;
  const float a = angle_deg / kDegrees;
  return {axis_.x + r * std::sin(a), hips_y_ + up * (shoulders_y_ - hips_y_), axis_.z + r * std::cos(a)};
}

float TrunkShape::depth_inside(Vec3f p) const {
  const float up = (p.y - hips_y_) / (shoulders_y_ - hips_y_);
  if (up < 0 || up > 1) return -1000;
  const float angle = std::atan2(p.x - axis_.x, p.z - axis_.z) * kDegrees;
  return radius(up, angle) - std::hypot(p.x - axis_.x, p.z - axis_.z);
}

}  // namespace im2fit::lab
