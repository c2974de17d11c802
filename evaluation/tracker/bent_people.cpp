// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/bent_people.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "body/skeleton.h"

namespace im2fit::lab {

Subject bent(const body::BodyModel& model, const Subject& subject, float bend_deg, float toward_deg) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  morph_subject(model, subject, rest);
  const body::Skeleton skeleton = body::rest_skeleton(model, rest);
  const Vec3f left = skeleton.head[static_cast<std::size_t>(body::Segment::left_upper_leg)];
  const Vec3f right = skeleton.head[static_cast<std::size_t>(body::Segment::right_upper_leg)];
  const Vec3f hips = (left + right) * 0.5F;
  const float toward = toward_deg * std::numbers::pi_v<float> / 180;
  const Vec3f axis{std::cos(toward), 0, -std::sin(toward)};  // of rest axes: x the person's left, y up, z forwards
  constexpr float kBendStartMm = 20, kBendSpanMm = 160;
  constexpr float kArmsFromMm = 330;  // sideways; no thigh reaches there
  Subject out = subject;
  // Also the helper vertices that mark where the joints are.
  out.rest_offset_mm.resize(rest.size());
  for (std::size_t i = 0; i < out.rest_offset_mm.size(); ++i) {
    const Vec3f from_hips = rest[i] - hips;
    // Hands of the rest pose hang below the hips, yet belong to the trunk.
    const bool arm = std::fabs(from_hips.x) > kArmsFromMm;
    const float share = arm ? 1 : std::clamp((from_hips.y - kBendStartMm) / kBendSpanMm, 0.0F, 1.0F);
    const Vec3f turned = body::rotation_about(axis, bend_deg * share) * from_hips;
    out.rest_offset_mm[i] = out.rest_offset_mm[i] + (turned - from_hips);
  }
  return out;
}

}  // namespace im2fit::lab
