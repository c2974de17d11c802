// SPDX-License-Identifier: Apache-2.0
// From an answer to the one body behind all reported values of a person: the nearest start body, changed until the
// mesh has the answered measurements, in the measured pose (docs/one-body.md).
#pragma once

#include <span>
#include <vector>

#include "body/fit/measurement_fit.h"
#include "body/model.h"
#include "body/skeleton.h"
#include "core/joints.h"
#include "core/status.h"
#include "index/index.h"
#include "perception/observe/observe.h"

namespace im2fit {

struct AnsweredBody {
  body::Params params;
  body::MeasurementFit fit;  // measurements of the mesh of `params`, and their distance from the answer
  body::Pose pose;  // as seen, else joints as measured; mesh axes; the hips above the origin, the floor (where known)
                    // at y = 0
  std::vector<Vec3f> rest = {};  // the mesh of `params`, all vertices; of body_of_answer and body_of_goals alone
};

// The goals of the mesh: the answered values, with standard deviations from their intervals.
body::MeasurementGoals goals_of(const index::Answer& answer);

// From the nearest of the body file's start bodies of the answered sex. `seen`: the body fitted to the pictures,
// whose shape and pose it follows, unless clothes were seen rather than skin. Errors: the body file has no start
// bodies; as body_of_goals. Allocates; a few hundredths of a second.
Result<AnsweredBody> body_of_answer(body::MeasurementFitter& fitter, const index::Answer& answer,
                                    const JointSet& measured_joints, const FloorPlane& floor,
                                    const body::SeenBody& seen = {});

// The same from a body to begin with. Errors: joints or goals that are not finite, goals that are not positive.
Result<AnsweredBody> body_of_goals(body::MeasurementFitter& fitter, const body::Params& start,
                                   const body::MeasurementGoals& goals, const JointSet& measured_joints,
                                   const FloorPlane& floor, const body::SeenBody& seen = {});

// To the axes of meshes (body/person_axes.h); see AnsweredBody::pose.
JointSet to_mesh_axes(const JointSet& camera_joints, const FloorPlane& floor);

}  // namespace im2fit
