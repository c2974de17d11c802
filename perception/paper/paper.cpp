// SPDX-License-Identifier: Apache-2.0
#include "perception/paper/paper.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/paper/plan.h"

namespace im2fit {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

BodyFrame body_frame(const JointSet& joints) {
  BodyFrame frame;
  if (!paper_detail::usable_joints(joints)) return frame;
  const Vec3f u = normalized(joints[Joint::TO] - joints[Joint::NE]);
  const Vec3f v = normalized(joints[Joint::RS] - joints[Joint::LS]);
  const Vec3f w = normalized(cross(u, v));
  if (!(norm(w) > 0.5F)) return frame;
  frame.u = u, frame.v = v, frame.w = w;
  const Vec3f d = normalized((joints[Joint::LH] + joints[Joint::RH]) * 0.5F - joints[Joint::TO]);
  if (!(norm(d) > 0.5F)) return frame;
  frame.lateral = norm(cross(u, d));  // sqrt(1 - (u.d)^2) without its cancellation
  frame.upright = frame.lateral < kUprightMax && dot(u, d) > 0;
  return frame;
}

PaperWorkspace::PaperWorkspace(int width, int height)
    : rays(width, height),
      spine(width, height),
      across(width, height),
      depth(width, height),
      point_capacity(std::min(kMomentPointsMax, width * height)),
      points(kPaperSectionCount * static_cast<std::size_t>(point_capacity + kSectionSlack)) {}

MeasurementValues to_values(const PaperMeasurements& m) {
  MeasurementValues values;
  values.fill(kNan);
  if (!m.valid) return values;
  const auto set = [&](Measurement id, float value) { values[measurement_index(id)] = value; };
  set(Measurement::stature, m.stature_mm);
  set(Measurement::sleeve_length, m.sleeve_mm);
  set(Measurement::leg_length, m.leg_mm);
  set(Measurement::shoulder_breadth, m.shoulder_mm);
  set(Measurement::neck_girth, m.neck_mm);
  set(Measurement::shoulder_girth, m.shoulder_girth_mm);
  set(Measurement::chest_girth, m.chest_mm);
  set(Measurement::waist_girth, m.waist_mm);
  set(Measurement::hip_girth, m.hip_mm);
  return values;
}

namespace paper_detail {

void set_girths(const std::array<float, kPaperSectionCount>& girths_mm, PaperMeasurements& m) {
  m.neck_mm = girths_mm[0];
  m.shoulder_girth_mm = girths_mm[1];
  m.chest_mm = girths_mm[2];
  m.waist_mm = girths_mm[3];
  m.hip_mm = girths_mm[4];
  m.hip_waist_ratio = m.hip_mm / m.waist_mm;
}

PaperMeasurements unmeasured() {
  PaperMeasurements m;
  m.stature_mm = m.sleeve_mm = m.leg_mm = m.shoulder_mm = m.chest_ratio = kNan;
  set_girths({kNan, kNan, kNan, kNan, kNan}, m);
  return m;
}

}  // namespace paper_detail

}  // namespace im2fit
