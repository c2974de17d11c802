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
    previous_user_ = 0;
    return sighting;
  }
  const bool follows = previous_user_ != 0 && previous_user_ == sighting.person.id;
  sighting.joints = tracker_.track(depth, mask, intrinsics, sighting.person, follows);
  sighting.back_chance = tracker_.back_chance();
  sighting.view = view_side(sighting.joints, sighting.person.floor, sighting.back_chance);
  sighting.guidance |=
      pose_gate(sighting.joints, sighting.person.floor, sighting.view) & pose_codes_seen(sighting.guidance);
  previous_user_ = sighting.person.id;
  return sighting;
}

void Sensor::reset() {
  segmenter_.reset();
  previous_user_ = 0;
}

}  // namespace im2fit
