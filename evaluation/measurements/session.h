// SPDX-License-Identifier: Apache-2.0
// A person before a camera before the engine, until it has measured or the person has stood there long enough.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "engine/engine.h"
#include "evaluation/measurements/evaluation.h"

namespace im2fit::lab {

struct SessionModels {
  const body::BodyModel& body;
  const JointModel& joints;
  const index::Index& index;
  const body::ShapeSpace* shape_space = nullptr;  // null: features answer alone
  std::optional<SiteCorrection> site = {};        // as EngineSettings
};

// Called after each frame with a person found: joints of the engine, and the truth.
using JointWatch = std::function<void(const JointSet& found, const JointSet& truth)>;

// A person who gets ARMS_CLOSE in `frames_wanted` frames lifts the arms, as real people do, and is shown from then on
// in the pose arms_out. Returns whether that happened.
bool told_to_lift_arms(const EngineResult& result, int frames_wanted);

// The engine as it stands after the session, finished. `watch` may be empty.
Result<std::unique_ptr<Engine>> run_session(const SessionModels& models, const HeldOutPerson& person, Views views,
                                            const JointWatch& watch);

}  // namespace im2fit::lab
