// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kernels/observe/gate.h"
#include "kernels/observe/observe.h"

namespace im2fit {

namespace {

constexpr float kLostShareMax = 0.30F;  // of the person's pixels

}  // namespace

Sensor::Sensor(int width, int height, const JointModel& model)
    : holes_(width, height), segmenter_(width, height), tracker_(model) {}

Sighting Sensor::sense(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds) {
  Sighting sighting;
  const DepthView mended = holes_.run(depth);
  sighting.person = segmenter_.run(mended, intrinsics, mask, seconds);
  for (const User& user : segmenter_.users()) sighting.users[static_cast<std::size_t>(sighting.user_count++)] = user;
  sighting.guidance = sighting.person.guidance;
  if (!sighting.person.found) {
    previous_user_ = 0;
    return sighting;
  }
  const bool follows = previous_user_ != 0 && previous_user_ == sighting.person.id;
  sighting.joints = tracker_.track(mended, mask, intrinsics, sighting.person, follows);
  const auto is_chosen = [&](const User& user) { return user.id == sighting.person.id; };
  const auto users = segmenter_.users();
  const auto user = std::find_if(users.begin(), users.end(), is_chosen);
  const Lean lean = lean_of(mended, mask, intrinsics, sighting.person, user != users.end() ? &*user : nullptr);
  // Who else is there is a guess as well.
  if (holes_.mended() && drop_lost_pixels(depth, mask) > kLostShareMax)
    sighting.guidance = (sighting.guidance & ~static_cast<GuidanceSet>(Guidance::several_people)) |
                        static_cast<GuidanceSet>(Guidance::too_noisy);
  sighting.back_chance = tracker_.back_chance();
  sighting.view = view_side(sighting.joints, sighting.person.floor, sighting.back_chance);
  sighting.guidance |= pose_gate(sighting.joints, sighting.person.floor, sighting.view, lean) &
                       pose_codes_seen(sighting.guidance, sighting.view);
  previous_user_ = sighting.person.id;
  return sighting;
}

void Sensor::reset() {
  segmenter_.reset();
  previous_user_ = 0;
}

}  // namespace im2fit
