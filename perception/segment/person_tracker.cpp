// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/person_tracker.h"

#include <algorithm>
#include <cmath>

#include "perception/segment/blobs.h"
#include "perception/segment/person_tracker_limits.h"

namespace im2fit {

using namespace person_tracker_limits;
using segment::at;

void PersonTracker::reset() {
  track_count_ = detection_count_ = keepout_count_ = expected_count_ = 0;
  first_ = true;
  looked_at_ = 0;
  release();
}

const PersonTracker::Track* PersonTracker::find(int id) const {
  const auto end = tracks_.begin() + track_count_;
  const auto found = std::find_if(tracks_.begin(), end, [id](const Track& track) { return track.id == id; });
  return found != end ? &*found : nullptr;
}

const PersonTracker::Track& PersonTracker::track_of(std::size_t user) const {
  return tracks_[at(detections_[user].track)];
}

// Not confirmed, but seen often enough, and not shaped like furniture.
bool PersonTracker::is_candidate(const Track& track) {
  return !track.confirmed && track.chances >= kConfirmed;
}

// Evidence by shape.

void PersonTracker::begin_evidence(Track& track, const segment::Blob& blob, bool first_frame) {
  track.evidence = !blob.person ? 0 : first_frame ? kConfirmed : kSeenGain;
  track.confirmed = track.evidence >= kConfirmed;
  note_shape(track, &blob);
  if (first_frame) track.chances = kConfirmed;
}

// Furniture may resemble a person in one frame, and stands there ever after.
void PersonTracker::add_evidence(Track& track, const segment::Blob& blob) {
  if (track.evidence < kSeenMax)
    track.evidence = blob.person ? std::min(track.evidence + kSeenGain, kSeenMax) : std::max(track.evidence - 1, 0);
  track.confirmed = track.evidence >= (track.confirmed ? kUnconfirmedBelow : kConfirmed);
  note_shape(track, &blob);
}

float PersonTracker::latest_share(const Track& track) {
  return static_cast<float>(kSeenGain) / static_cast<float>(track.evidence + kSeenGain);
}

// Furniture has a person's shape for a frame now and then: a frame without it, or without a detection, counts against
// an unconfirmed user.
void PersonTracker::note_shape(Track& track, const segment::Blob* blob) {
  const bool chance = blob != nullptr && (blob->person || blob->candidate);
  track.chances = chance ? std::min(track.chances + kSeenGain, kSeenMax) : std::max(track.chances - 1, 0);
  const bool known = blob != nullptr && blob->shape_odds != segment::kShapeUnknown;
  if (!known && (track.confirmed || (blob != nullptr && blob->person))) return;
  track.shape_frames = std::min(track.shape_frames + 1, kShapeFramesMax);
  track.shape_odds +=
      ((known ? blob->shape_odds : kShapelessOdds) - track.shape_odds) / static_cast<float>(track.shape_frames);
}

float PersonTracker::shape_odds(int id) const {
  const Track* track = find(id);
  return track != nullptr ? track->shape_odds : 0;
}

// Evidence by joints.

bool PersonTracker::accepted(int id) const {
  const Track* track = find(id);
  return id == selected_ || (track != nullptr && track->accepted);
}

bool PersonTracker::judged_person(Track& track, const JointEvidence& evidence) {
  // The latest frames': who raised the arms before may be found with them down.
  if (track.judged_frames >= kLongFrames)
    track.joint_odds_sum -= track.joint_odds_sum / static_cast<float>(kLongFrames);
  track.joint_odds_sum += evidence.odds;
  ++track.judged_frames;
  const float sure = track.shape_odds == 0 ? kPersonScoreSureShapeless : kPersonScoreSure;
  if (track.confirmed && evidence.person_score >= sure && evidence.odds >= kOddsSure) return true;
  const float least = !evidence.floor_known ? kOddsMinFloorless : track.confirmed ? kOddsSure : kOddsMin;
  return track.judged_frames >= kOddsFrames && mean_joint_odds(track) >= least;
}

bool PersonTracker::judged_enough(const Track& track) {
  return track.judged_frames > kLongFrames ||
         (track.judged_frames >= kHopelessFrames && mean_joint_odds(track) < kHopelessOdds);
}

float PersonTracker::mean_joint_odds(const Track& track) {
  return track.joint_odds_sum / static_cast<float>(std::min(track.judged_frames, kLongFrames));
}

bool PersonTracker::judge(int id, const JointEvidence& evidence) {
  if (accepted(id)) return true;
  Track* track = find(id);
  if (track == nullptr) return false;
  const bool person = judged_person(*track, evidence);
  if (person)
    accept(id);
  else if (track->confirmed || judged_enough(*track))
    reject(id);
  return person;
}

void PersonTracker::accept(int id) {
  Track* track = find(id);
  if (track == nullptr) return;
  track->accepted = true;
  track->rejected = false;
  if (track->confirmed) return;
  track->evidence = kSeenMax;
  track->confirmed = true;
}

void PersonTracker::reject(int id) {
  if (Track* track = find(id)) track->rejected = true;
}

// Choice.

int PersonTracker::choose() const {
  int best = -1;
  float best_cost = 1e30F;
  for (std::size_t i = 0; i < users().size(); ++i) {
    const User& user = users_[i];
    const Track& track = track_of(i);
    if (selected_ != 0 && user.id != selected_) continue;
    if (user.left_out != LeftOut::no) continue;
    const bool candidate = is_candidate(track);
    if (!user.confirmed && !candidate) continue;
    const Vec3f c = user.centroid_mm;
    float cost_mm = c.z + kAsideShare * std::fabs(c.x) + (user.has_head ? 0.0F : kHeadlessMm);
    if (user.id == looked_at_) cost_mm -= kStayMm;
    if (candidate) cost_mm += kUnconfirmedCostMm;
    if (track.rejected) cost_mm += kUnconfirmedCostMm;
    if (cost_mm < best_cost) {
      best_cost = cost_mm;
      best = static_cast<int>(i);
    }
  }
  return best;
}

void PersonTracker::look_at(int user) {
  looked_at_ = user >= 0 ? users_[at(user)].id : 0;
}

int PersonTracker::people_count() const {
  const auto list = users();
  return static_cast<int>(std::count_if(list.begin(), list.end(), [](const User& user) { return user.confirmed; }));
}

// The joints of others are not estimated: an unconfirmed candidate counts only if shaped like a person.
bool PersonTracker::disturbed(int user) const {
  const float limit = users_[at(user)].centroid_mm.z + kFarBehindMm;
  for (std::size_t i = 0; i < users().size(); ++i) {
    const Track& other = track_of(i);
    if (i == at(user) || users_[i].centroid_mm.z >= limit || other.rejected) continue;
    const bool told_apart = requested_ != 0 || users_[i].left_out != LeftOut::no;
    if (told_apart && !segment::hides(users_[i], users_[at(user)])) continue;
    if (users_[i].confirmed || (is_candidate(other) && other.shape_odds > kDisturbingOdds)) return true;
  }
  return false;
}

// Session.

void PersonTracker::select(int id) {
  requested_ = selected_ = id;
  absent_periods_ = 0;
}

void PersonTracker::hold(int shown, bool ready, int periods) {
  if (requested_ != 0) return;
  if (shown != 0) {
    absent_periods_ = 0;
    if (selected_ == 0 && ready) selected_ = shown;
  } else if (selected_ != 0) {
    absent_periods_ += periods;
    if (absent_periods_ > kAbsentPeriodsMax) release();
  }
}

}  // namespace im2fit
