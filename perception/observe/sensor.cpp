// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "perception/observe/gate.h"
#include "perception/observe/observe.h"

namespace im2fit {

namespace {

// JointTracker::likeness and somebody_odds() of somebody at once, where the segmenter says so too:
constexpr float kLikenessSure = 0.76F;
constexpr float kLikenessSureShapeless = 0.82F;
constexpr float kOddsSure = -1.0F;
// somebody_odds() in the mean over so many frames, of who is not sure at once:
constexpr int kOddsFrames = 6;
constexpr float kOddsMin = 1.5F;
constexpr int kLongFrames = 12;     // A doubtful one is looked at so long;
constexpr int kHopelessFrames = 4;  // hopeless ones no longer than this. Others are looked at, after.
constexpr float kHopelessOdds = -2.0F;
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
    const bool confirmed = listed != sighting.users.end() && listed->confirmed;
    const bool somebody = looks_like_somebody(sighting.person.id, confirmed);
    // Who is doubtful to begin with is in nobody's way: looked at until others should be.
    if (somebody || confirmed || looked_at_enough()) segmenter_.doubt(sighting.person.id, !somebody);
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

Sensor::Candidate& Sensor::candidate(int id) {
  auto found = std::find_if(candidates_.begin(), candidates_.end(), [id](const Candidate& c) { return c.id == id; });
  if (found == candidates_.end()) *--found = {id, 0, 0};
  std::rotate(candidates_.begin(), found, found + 1);
  return candidates_.front();
}

bool Sensor::looks_like_somebody(int id, bool confirmed) {
  Candidate& c = candidate(id);
  const float shape = segmenter_.shape_odds(id);
  const float odds = tracker_.somebody_odds(shape);
  c.odds_sum += odds;
  ++c.frames;
  const float sure = shape == 0 ? kLikenessSureShapeless : kLikenessSure;
  if (confirmed && tracker_.likeness() >= sure && odds >= kOddsSure) return true;
  return c.frames >= kOddsFrames && c.odds_sum >= kOddsMin * static_cast<float>(c.frames);
}

// Of the candidate looked at last.
bool Sensor::looked_at_enough() const {
  const Candidate& c = candidates_.front();
  return c.frames > kLongFrames ||
         (c.frames >= kHopelessFrames && c.odds_sum < kHopelessOdds * static_cast<float>(c.frames));
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
  // What is too near to be told from furniture is too near.
  const auto near = doubted.person.guidance & static_cast<GuidanceSet>(Guidance::too_near);
  sighting.guidance = sighting.person.guidance = near != 0 ? near : static_cast<GuidanceSet>(Guidance::no_person);
  previous_user_ = 0;
  return sighting;
}

void Sensor::reset() {
  segmenter_.reset();
  accepted_ = {};
  candidates_ = {};
  previous_user_ = selected_user_ = 0;
}

}  // namespace im2fit
