// SPDX-License-Identifier: Apache-2.0
// The start bodies of a body file: workstation side of body/start_bodies.
#pragma once

#include <cstdint>
#include <vector>

#include "body/start_bodies.h"

namespace im2fit::lab {

struct StartBodyOptions {
  int people = 2000;  // of the training family, among whom the start bodies are; half of them men
  int starts = 200;   // half of them men
  std::uint64_t seed = 0x57A7;
  int threads = 2;  // does not change the result
};
struct PickedStartBodies {
  std::vector<body::StartBody> men, women;
};

// Of each sex in turn the person who most reduces the sum, over all people drawn of that sex, of the squared
// body::MeasurementDistance to the nearest one picked: common builds get more start bodies, rare ones some.
PickedStartBodies pick_start_bodies(const body::BodyModel& model, const StartBodyOptions& options);

}  // namespace im2fit::lab
