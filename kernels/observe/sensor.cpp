// SPDX-License-Identifier: Apache-2.0
#include "kernels/observe/gate.h"
#include "kernels/observe/observe.h"

namespace im2fit {

Sensor::Sensor(int width, int height, const JointModel& model) : segmenter_(width, height), tracker_(model) {}

Sighting Sensor::sense(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds) {
  Sighting sighting;
  sighting.person = segmenter_.run(depth, intrinsics, mask, seconds);
  for (const User& user : segmenter_.users()) sighting.users[static_cast<std::size_t>(sighting.user_count++)] = user;
  sighting.guidance = sighting.person.guidance;
  if (!sighting.person.found) {
    has_previous_ = false;
    return sighting;
  }
  sighting.joints = tracker_.track(depth, mask, intrinsics, sighting.person, has_previous_ ? &previous_ : nullptr);
  sighting.view = view_side(sighting.joints, sighting.person.floor);
  sighting.guidance |= pose_gate(sighting.joints, sighting.person.floor, sighting.view);
  previous_ = sighting.joints;
  has_previous_ = true;
  return sighting;
}

void Sensor::reset() {
  segmenter_.reset();
  has_previous_ = false;
}

}  // namespace im2fit
