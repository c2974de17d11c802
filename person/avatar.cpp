// SPDX-License-Identifier: Apache-2.0
#include "person/avatar.h"

#include <cmath>
#include <string>

#include "body/fit/nearest_start.h"
#include "body/person_axes.h"
#include "body/start_bodies.h"

namespace im2fit {
JointSet to_mesh_axes(const JointSet& camera_joints, const FloorPlane& floor) {
  return body::PersonAxes(camera_joints, floor).to_mesh(camera_joints);
}

body::MeasurementGoals goals_of(const index::Answer& answer) {
  constexpr float kSdsInInterval = 2 * 1.96F;  // 95 % of a normal distribution
  body::MeasurementGoals goals;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const index::IntervalEstimate& e = answer.measurements[i];
    goals[i] = {e.value, (e.high - e.low) / kSdsInInterval};
  }
  return goals;
}

Result<AnsweredBody> body_of_goals(body::MeasurementFitter& fitter, const body::Params& start,
                                   const body::MeasurementGoals& goals, const JointSet& measured_joints,
                                   const FloorPlane& floor, const body::SeenBody& seen) {
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const Vec3f& p = measured_joints.position_mm[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      return Error{ErrorCode::invalid_argument, "joint " + std::string(kJointNames[i]) + " is not a finite position"};
  }
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    if (!std::isfinite(goals[i].value) || goals[i].value <= 0)
      return Error{ErrorCode::invalid_argument,
                   "estimated " + std::string(kMeasurementTable[i].id) + " is not a positive number"};

  AnsweredBody answered;
  answered.params = start;
  answered.fit = fitter.run(answered.params, goals, seen.valid ? &seen : nullptr);
  const std::span<const Vec3f> rest = fitter.measured().rest();
  answered.rest.assign(rest.begin(), rest.end());
  answered.pose = seen.valid
                      ? seen.pose
                      : body::pose_from_joints(fitter.measured().rest_bones(), to_mesh_axes(measured_joints, floor));
  return answered;
}

Result<AnsweredBody> body_of_answer(body::MeasurementFitter& fitter, const index::Answer& answer,
                                    const JointSet& measured_joints, const FloorPlane& floor,
                                    const body::SeenBody& seen) {
  const body::StartBodies& starts = fitter.model().start_bodies();
  if (starts.size() == 0)
    return Error{ErrorCode::unsupported, "the body file has no start bodies; make it again: im2fit-lab fetch"};
  const body::MeasurementGoals goals = goals_of(answer);
  MeasurementValues values;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) values[i] = goals[i].value;
  const std::size_t nearest = body::nearest_start(starts, answer.female >= 0.5F, values);
  // Of a dressed person the skin seen is cloth.
  return body_of_goals(fitter, starts.params(nearest), goals, measured_joints, floor,
                       answer.clothed ? body::SeenBody{} : seen);
}

}  // namespace im2fit
