// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kernels/observe/gate.h"
#include "kernels/observe/observe.h"

namespace im2fit {

namespace {

// JointTracker::likeness. Of 250 people in full conditions none has less than 0.73 in the first frame, of 245 seen
// from anywhere 2 have less than 0.7; furniture taken for people has 0.6 to 0.8, mostly below 0.7 and trembling. With
// 0.78 for sure, 10 of 10,000 empty frames have somebody instead of 28, but one free pose in thirty is not seen.
constexpr float kLikenessSure = 0.72F;  // somebody at once
constexpr float kLikenessMin = 0.67F;   // somebody after kLikeFrames in a row
constexpr int kLikeFrames = 6;
// With the shape's log-odds (Segmenter::shape_odds; weighed together, see there).
constexpr float kOddsOfLikeness = 22.0F;
constexpr float kLikenessEven = 0.65F;
constexpr float kOddsMin = 0.3F;          // in the mean, of who is not sure at once
constexpr float kOddsDoubtfulMin = 0.8F;  // ... and whose shape alone does not tell either
constexpr int kOddsFrames = 6;
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
  if (!accepted(sighting.person.id)) {
    const auto listed = std::find_if(sighting.users.begin(), sighting.users.end(),
                                     [&](const User& user) { return user.id == sighting.person.id; });
    const bool somebody =
        looks_like_somebody(sighting.person.id, listed != sighting.users.end() && listed->confirmed);
    segmenter_.doubt(sighting.person.id, !somebody);
    if (!somebody) return nobody(sighting, mask);
    accept(sighting.person.id);
  }
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

// Once somebody, always somebody: people bend and turn away.
bool Sensor::accepted(int id) const {
  return id == selected_user_ || std::find(accepted_.begin(), accepted_.end(), id) != accepted_.end();
}

bool Sensor::looks_like_somebody(int id, bool confirmed) {
  if (id != like_user_) {
    like_frames_ = odds_frames_ = 0;
    odds_sum_ = 0;
  }
  like_user_ = id;
  const float likeness = tracker_.likeness();
  const float odds = segmenter_.shape_odds(id) + kOddsOfLikeness * (likeness - kLikenessEven);
  like_frames_ = likeness < kLikenessMin ? 0 : like_frames_ + 1;
  odds_sum_ += odds;
  ++odds_frames_;
  const float odds_min = confirmed ? kOddsMin : kOddsDoubtfulMin;
  const bool told = odds_frames_ >= kOddsFrames && odds_sum_ >= odds_min * static_cast<float>(odds_frames_);
  const bool like = likeness >= kLikenessSure || like_frames_ >= kLikeFrames;
  return told || (confirmed && like && odds >= 0);
}

void Sensor::accept(int id) {
  std::copy_backward(accepted_.begin(), accepted_.end() - 1, accepted_.end());
  accepted_[0] = id;
}

Sighting Sensor::nobody(const Sighting& doubted, MaskImage mask) {
  for (int v = 0; v < mask.height; ++v) std::fill_n(mask.row(v), mask.width, std::uint8_t{0});
  Sighting sighting;
  sighting.person.floor = doubted.person.floor;
  for (int i = 0; i < doubted.user_count; ++i)
    if (doubted.users[static_cast<std::size_t>(i)].id != doubted.person.id)
      sighting.users[static_cast<std::size_t>(sighting.user_count++)] = doubted.users[static_cast<std::size_t>(i)];
  sighting.person.people_count = std::max(0, doubted.person.people_count - 1);
  sighting.guidance = sighting.person.guidance = static_cast<GuidanceSet>(Guidance::no_person);
  previous_user_ = 0;
  return sighting;
}

void Sensor::reset() {
  segmenter_.reset();
  accepted_ = {};
  previous_user_ = selected_user_ = like_user_ = 0;
}

}  // namespace im2fit
