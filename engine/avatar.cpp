// SPDX-License-Identifier: Apache-2.0
#include "engine/avatar.h"

#include <cmath>
#include <string>
#include <vector>

#include "body/measure.h"
#include "body/person_axes.h"
#include "body/population.h"

namespace im2fit {
namespace {

// Heavy bodies come into reach as muscle falls (body/measure.h), so muscle is given up before the weight is.
bool solve(const body::BodyModel& model, body::Params& params, double stature_mm, double weight_kg) {
  for (const float muscle_kept : {1.0F, 0.6F, 0.3F}) {
    body::Params tried = params;
    tried.muscle *= muscle_kept;
    const bool solved = body::solve_stature_and_weight(model, tried, stature_mm, weight_kg);
    if (solved || muscle_kept == 0.3F) {
      params = tried;
      return solved;
    }
  }
  return false;
}

}  // namespace

JointSet to_mesh_axes(const JointSet& camera_joints, const FloorPlane& floor) {
  return body::PersonAxes(camera_joints, floor).to_mesh(camera_joints);
}

Result<AnsweredBody> body_of_params(const body::BodyModel& model, const body::Params& params, double stature_mm,
                                    double weight_kg, const JointSet& measured_joints, const FloorPlane& floor) {
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const Vec3f& p = measured_joints.position_mm[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      return Error{ErrorCode::invalid_argument, "joint " + std::string(kJointNames[i]) + " is not a finite position"};
  }
  if (!std::isfinite(stature_mm) || !std::isfinite(weight_kg) || stature_mm <= 0 || weight_kg <= 0)
    return Error{ErrorCode::invalid_argument, "answered stature and weight must be positive"};

  AnsweredBody answered;
  answered.params = params;
  answered.in_reach = solve(model, answered.params, stature_mm, weight_kg);
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(answered.params, rest);
  answered.pose = body::pose_from_joints(body::rest_skeleton(model, rest), to_mesh_axes(measured_joints, floor));
  return answered;
}

Result<AnsweredBody> body_of_answer(const body::BodyModel& model, const index::Index& index,
                                    const index::Answer& answer, const JointSet& measured_joints,
                                    const FloorPlane& floor) {
  const auto person = index.person_of(answer.nearest);
  if (!person) return person.error();
  const auto params = body::params_of_person(model, person->version, person->seed, person->number);
  if (!params) return params.error();
  const auto value = [&](Measurement m) {
    return static_cast<double>(answer.measurements[measurement_index(m)].value);
  };
  return body_of_params(model, *params, value(Measurement::stature), value(Measurement::weight), measured_joints,
                        floor);
}

}  // namespace im2fit
