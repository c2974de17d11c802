// SPDX-License-Identifier: Apache-2.0
// What body data, a tracker and an index would be made of by this code: declared versions, and a checksum of a small
// trial run of the same code. Data made earlier is still good when its fingerprint is. A change of arithmetic changes
// the trial's bits; a comment, a name or a message does not.
#pragma once

#include <string>

#include "body/model.h"
#include "core/status.h"
#include "perception/joints/tracker.h"

namespace im2fit::lab {

// Shapes of 24 people: some two seconds.
Result<std::string> body_fingerprint(const body::BodyModel& model);
// A tracker of 40 renders: some five seconds.
Result<std::string> tracker_fingerprint(const body::BodyModel& model);
// Samples of four people as `joint_model` sees them, and an index of invented samples: some five seconds.
Result<std::string> index_fingerprint(const body::BodyModel& model, const JointModel& joint_model);

}  // namespace im2fit::lab
