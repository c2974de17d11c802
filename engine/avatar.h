// SPDX-License-Identifier: Apache-2.0
// From an answer to a body: the nearest entry's parameters brought to the answered stature and weight, in the pose
// that was measured.
#pragma once

#include <span>

#include "body/model.h"
#include "body/skeleton.h"
#include "core/joints.h"
#include "core/status.h"
#include "index/index.h"
#include "perception/observe/observe.h"

namespace im2fit {

struct AnsweredBody {
  body::Params params;
  body::Pose pose;       // joints as measured, mesh axes; the hips above the origin, the floor (where known) at y = 0
  bool in_reach = true;  // false: stature or weight is beyond the body model, params hold the nearest
};

// `model`: of the body file the index was built with; another one draws other people unnoticed. Errors: the index was
// built of another version of the population; as body_of_params.
Result<AnsweredBody> body_of_answer(const body::BodyModel& model, const index::Index& index,
                                    const index::Answer& answer, const JointSet& measured_joints,
                                    const FloorPlane& floor);

// The same from sliders. Errors: joints, stature or weight that are not finite or not positive.
Result<AnsweredBody> body_of_params(const body::BodyModel& model, const body::Params& params, double stature_mm,
                                    double weight_kg, const JointSet& measured_joints, const FloorPlane& floor);

// To the axes of meshes (body/person_axes.h); see AnsweredBody::pose.
JointSet to_mesh_axes(const JointSet& camera_joints, const FloorPlane& floor);

}  // namespace im2fit
