// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "perception/segment/blobs.h"
#include "perception/segment/person_tracker.h"

// The thresholds of this file: what each bounds and where it comes from. What breaks when one moves by 20 %:
// docs/notebook/perception.md. Sources:
//   [ids]    came with ids, or with ids that last longer: 50 clips of two people who pass, 3 switches before, 0
//            after, all changes together (commits 9873af9, f1a81d9)
//   [heads]  came with users whose heads are not seen (commit e8175d0); no measurement on record
//   [hidden] of 50 two-person clips, seed 909090: changes of id 6 before, 2 after (commit a16e488)
//   [stand]  the same clips: 2 before, 0 after (commit a94b161)
//   [odds]   came with log-odds of the shape (commit f771803): false users of 10,000 empty frames 10 before, 0
//            after
//   [rooms]  chosen on synthetic rooms, no measurement on record
namespace im2fit::person_matching_limits {

// How long.
constexpr float kHiddenMaxS = 5.0F;             // a confirmed user may stay hidden; [ids]
constexpr float kUnconfirmedHiddenMaxS = 1.0F;  // an unconfirmed one; [ids]
constexpr float kHeadlessHiddenMaxS = 1.5F;     // then what returns without a head may be furniture; [ids]
constexpr float kHeadlessMaxS = 1.0F;           // a user may lack both head and a person's size; [heads]
constexpr float kExpectedMaxS = 1.0F;           // a hidden head is still expected; [rooms]
constexpr float kCandidateHiddenMaxS = 0.3F;    // a confirmed user may be continued by a candidate; [odds]

// Association of tracks and detections.
constexpr float kGateMm = 350.0F;            // most: a head's jump when a raised arm is taken for it; [rooms]
constexpr float kGateGrowthMmPerS = 600.0F;  // more while hidden: people stop and turn; [ids]
constexpr float kGateMaxMm = 1400.0F;        // but no more than that; [ids]
constexpr float kTopGateMm = 250.0F;         // between heights of crowns: two people of unlike height; [ids]
constexpr float kOverHeadMm = 150.0F;        // a surface that much above the head is a coat stand; [stand]
constexpr float kHeadlessGateMm = 350.0F;    // of a detection without a head; [heads]
constexpr float kHeadlessTallMm = 300.0F;    // its height, least; [heads]
constexpr float kHeadlessAreaMin = 0.35F;    // of the most seen of the person, least; [heads]
constexpr float kHeadlessAreaMax = 1.4F;     // and most; [heads]
constexpr float kBesideMm = 1000.0F;         // a new candidate so near a confirmed user is part of it; [stand]
constexpr float kUnprovenMm = 600.0F;        // cost of a track that never had a person's shape; [hidden]
constexpr float kNoTopMm = 60.0F;            // cost where either has no crown; [ids]
constexpr float kLateMm = 100.0F;            // cost of a hidden track; [ids]

// An alpha-beta filter of places along the floor.
constexpr float kPlaceGain = 0.6F;          // of the place: heads are seen to a cell, 20 mm; [ids]
constexpr float kSpeedGain = 0.12F;         // of the speed; a new track learns faster; [ids]
constexpr float kSpeedMaxMmPerS = 3000.0F;  // people walk and run slower; [ids]
constexpr float kTopGain = 0.2F;            // of the crown's height; [ids]
constexpr float kAreaKeep = 0.999F;         // of the most seen area, per frame; [ids]

}  // namespace im2fit::person_matching_limits

namespace im2fit {

using namespace person_matching_limits;
using segment::at;
using segment::Blob;
using segment::Blobs;
using segment::Grid;
using segment::Keepout;

namespace {

Vec3f along_floor(Vec3f p, const FloorPlane& floor) {
  const Vec3f up = floor.up;
  return p - up * dot(up, p);
}

// From p to the line between a and b.
float distance_to(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3f path = b - a;
  const float length2 = dot(path, path);
  const float share = length2 > 1.0F ? std::clamp(dot(p - a, path) / length2, 0.0F, 1.0F) : 0.0F;
  return norm(p - (a + path * share));
}

}  // namespace

PersonTracker::BlobDetection PersonTracker::describe(const Blob& blob, int index, const FloorPlane& floor) {
  BlobDetection s;
  s.blob = index;
  s.centroid_mm = along_floor(blob.centroid_mm, floor);
  s.place_mm = blob.has_head ? along_floor(blob.head_mm, floor) : s.centroid_mm;
  s.top_mm = blob.height_max_mm;
  s.has_head = blob.has_head;
  if (blob.has_head && floor.known) {  // a coat stand beside the head or a raised hand does not count as stature
    const float head_mm = dot(floor.up, blob.head_mm) + floor.camera_height_mm;
    if (s.top_mm > head_mm + kOverHeadMm) s.top_mm = head_mm;
  }
  s.has_top = blob.has_head && floor.known;
  return s;
}

// The nearest ones where there are too many.
void PersonTracker::list_detections(const Blobs& found, const FloorPlane& floor) {
  detection_count_ = 0;
  const auto list = found.list();
  for (std::size_t b = 0; b < list.size(); ++b) {
    const Blob& blob = list[b];
    if (!blob.person) continue;
    int where = detection_count_;
    while (where > 0 && list[at(detections_[at(where - 1)].blob)].centroid_mm.z > blob.centroid_mm.z) --where;
    if (where == kUserCountMax) continue;
    detection_count_ = std::min(detection_count_ + 1, kUserCountMax);
    for (int i = detection_count_ - 1; i > where; --i) detections_[at(i)] = detections_[at(i - 1)];
    detections_[at(where)] = describe(blob, static_cast<int>(b), floor);
  }
}

// People known from the frames before, whose heads are not seen now: what stands where they are expected and is as
// large as they were.
void PersonTracker::find_headless(const Blobs& found, const FloorPlane& floor) {
  const auto list = found.list();
  for (int t = 0; t < track_count_; ++t) {
    Track& track = tracks_[at(t)];
    if (track.detection >= 0 || track.hidden_s > kHeadlessHiddenMaxS || detection_count_ == kUserCountMax) continue;
    const bool confirmed = track.confirmed;
    float nearest = kHeadlessGateMm;
    int best = -1;
    for (std::size_t b = 0; b < list.size(); ++b) {
      const Blob& blob = list[b];
      const bool alike =
          blob.person_sized || (confirmed && track.headless_s < kHeadlessMaxS &&
                                blob.height_max_mm - blob.height_min_mm > kHeadlessTallMm &&
                                blob.relief_mm > 14.0F + 0.4F * segment::quantum_mm(blob.centroid_mm.z));
      if (blob.person || !alike || blob.area_m2 < kHeadlessAreaMin * track.area_m2 ||
          blob.area_m2 > kHeadlessAreaMax * track.area_m2)
        continue;
      if (track.has_top && blob.height_max_mm > track.top_mm + kTopGateMm) continue;
      const Vec3f place = along_floor(blob.centroid_mm, floor) + track.lean_mm;
      const float away = distance_to(place, track.seen_mm, track.expected_mm);
      if (taken(static_cast<int>(b)) || away >= nearest) continue;
      nearest = away;
      best = static_cast<int>(b);
    }
    if (best < 0) continue;
    detections_[at(detection_count_)] = describe(list[at(best)], best, floor);
    detections_[at(detection_count_)].track = t;
    track.detection = detection_count_++;
  }
}

bool PersonTracker::taken(int blob) const {
  return std::any_of(detections_.begin(), detections_.begin() + detection_count_,
                     [blob](const BlobDetection& s) { return s.blob == blob; });
}

// Unconfirmed candidates: continue one of the last frames, a person seen a moment ago, or a new one.
void PersonTracker::list_candidates(const Blobs& found, const FloorPlane& floor) {
  const auto list = found.list();
  for (std::size_t b = 0; b < list.size() && detection_count_ < kUserCountMax; ++b) {
    if (!list[b].candidate || taken(static_cast<int>(b))) continue;
    BlobDetection s = describe(list[b], static_cast<int>(b), floor);
    float nearest = kHeadlessGateMm;
    for (int t = 0; t < track_count_; ++t) {
      const Track& track = tracks_[at(t)];
      if (track.detection >= 0 || (track.confirmed && track.hidden_s > kCandidateHiddenMaxS)) continue;
      const float away = distance_to(s.place_mm + track.lean_mm, track.seen_mm, track.expected_mm);
      if (away >= nearest) continue;
      nearest = away;
      s.track = t;
    }
    if (s.track < 0 && beside_person(s.place_mm)) continue;
    if (s.track >= 0) tracks_[at(s.track)].detection = detection_count_;
    detections_[at(detection_count_++)] = s;
  }
}

// What appears there is more likely a part of that person, seen past another one, than one more person.
bool PersonTracker::beside_person(Vec3f place_mm) const {
  return std::any_of(tracks_.begin(), tracks_.begin() + track_count_, [&](const Track& track) {
    return track.confirmed && distance_to(place_mm, track.seen_mm, track.expected_mm) < kBesideMm;
  });
}

// Association cost of a track and a detection, mm; negative: they do not match.
float PersonTracker::cost(const Track& track, const BlobDetection& detection) {
  const float gate = std::min(kGateMaxMm, kGateMm + kGateGrowthMmPerS * track.hidden_s);
  const Vec3f place = detection.has_head ? detection.place_mm : detection.place_mm + track.lean_mm;
  const float away = distance_to(place, track.seen_mm, track.expected_mm);
  if (away > gate) return -1.0F;
  if (!track.has_top || !detection.has_top) return away + kNoTopMm;
  const float taller = std::fabs(track.top_mm - detection.top_mm);
  if (track.hidden_s > 0.3F && taller > kTopGateMm) return -1.0F;
  return away + std::min(taller, kTopGateMm);
}

// Least cost first. People are apart by more than they move in a frame: no better pairing is missed.
void PersonTracker::match() {
  for (int t = 0; t < track_count_; ++t) tracks_[at(t)].detection = -1;
  for (;;) {
    float best = 1e9F;
    int best_track = -1;
    int best_detection = -1;
    for (int t = 0; t < track_count_; ++t) {
      if (tracks_[at(t)].detection >= 0) continue;
      for (int s = 0; s < detection_count_; ++s) {
        if (detections_[at(s)].track >= 0) continue;
        // A track seen a frame ago comes before a hidden one.
        const float cost_mm = cost(tracks_[at(t)], detections_[at(s)]);
        const float late = tracks_[at(t)].hidden_s > 0 ? kLateMm : 0.0F;
        // What never had a person's shape may be a part of a hidden person, whose track comes first.
        const float unproven = tracks_[at(t)].evidence == 0 ? kUnprovenMm : 0.0F;
        if (cost_mm < 0 || cost_mm + late + unproven >= best) continue;
        best = cost_mm + late + unproven;
        best_track = t;
        best_detection = s;
      }
    }
    if (best_track < 0) return;
    tracks_[at(best_track)].detection = best_detection;
    detections_[at(best_detection)].track = best_track;
  }
}

void PersonTracker::move(Track& track, const BlobDetection& detection, const Blob& blob, float seconds) {
  const Vec3f place = detection.has_head ? detection.place_mm : detection.place_mm + track.lean_mm;
  const Vec3f off = place - track.expected_mm;
  const bool hidden = track.hidden_s > 0;
  track.seen_mm = hidden ? place : track.expected_mm + off * kPlaceGain;
  // After a gap the error grew over all of it; a new track's speed is learned from little.
  const float gain = hidden ? 0.5F : std::max(kSpeedGain, latest_share(track));
  const float since = seconds + track.hidden_s;
  track.speed_mm_s = track.speed_mm_s + off * (gain / since);
  const float speed = norm(track.speed_mm_s);
  if (speed > kSpeedMaxMmPerS) track.speed_mm_s = track.speed_mm_s * (kSpeedMaxMmPerS / speed);
  if (detection.has_head) track.lean_mm = detection.place_mm - detection.centroid_mm;
  track.headless_s = detection.has_head ? 0.0F : track.headless_s + since;
  if (detection.has_top) {
    track.top_mm = track.has_top ? track.top_mm + kTopGain * (detection.top_mm - track.top_mm) : detection.top_mm;
    track.has_top = true;
  }
  track.expected_mm = track.seen_mm;
  track.area_m2 = std::max(blob.area_m2, track.area_m2 * kAreaKeep);
  track.hidden_s = 0;
}

// Where all are taken, the one hidden longest goes.
PersonTracker::Track& PersonTracker::new_track() {
  if (track_count_ < kTrackCountMax) return tracks_[at(track_count_++)];
  int oldest = 0;
  for (int t = 1; t < track_count_; ++t)
    if (tracks_[at(t)].hidden_s > tracks_[at(oldest)].hidden_s) oldest = t;
  return tracks_[at(oldest)];
}

void PersonTracker::continue_tracks(const Blobs& found, float seconds) {
  int kept = 0;
  for (int t = 0; t < track_count_; ++t) {
    Track& track = tracks_[at(t)];
    if (track.detection >= 0) {
      const BlobDetection& s = detections_[at(track.detection)];
      const Blob& blob = found.list()[at(s.blob)];
      move(track, s, blob, seconds);
      add_evidence(track, blob);
    } else {
      track.hidden_s += seconds;
      if (!track.confirmed) note_shape(track, nullptr);
      if (track.hidden_s > (track.confirmed ? kHiddenMaxS : kUnconfirmedHiddenMaxS)) continue;
    }
    tracks_[at(kept++)] = track;
  }
  track_count_ = kept;
  for (int t = 0; t < track_count_; ++t)
    if (tracks_[at(t)].detection >= 0) detections_[at(tracks_[at(t)].detection)].track = t;
}

void PersonTracker::begin_tracks(const Blobs& found) {
  for (int i = 0; i < detection_count_; ++i) {
    BlobDetection& s = detections_[at(i)];
    if (s.track >= 0) continue;
    const Blob& blob = found.list()[at(s.blob)];
    Track& track = new_track();
    track = {};
    track.id = ++id_last_;
    track.seen_mm = track.expected_mm = s.place_mm;
    track.top_mm = s.top_mm;
    track.has_top = s.has_top;
    if (s.has_head) track.lean_mm = s.place_mm - s.centroid_mm;
    track.area_m2 = blob.area_m2;
    track.detection = i;
    s.track = static_cast<int>(&track - tracks_.data());
    begin_evidence(track, blob, first_);
  }
}

void PersonTracker::follow(const Grid& grid, const Blobs& found, const FloorPlane& floor, float seconds) {
  for (int t = 0; t < track_count_; ++t)
    tracks_[at(t)].expected_mm = tracks_[at(t)].expected_mm + tracks_[at(t)].speed_mm_s * seconds;
  list_detections(found, floor);
  match();
  find_headless(found, floor);
  list_candidates(found, floor);
  continue_tracks(found, seconds);
  begin_tracks(found);
  list_users(grid, found);
  leave_out(grid, found, floor, seconds);
  list_keepouts(found);
  list_expected(floor, seconds);
  first_ = false;
}

void PersonTracker::list_expected(const FloorPlane& floor, float seconds) {
  const Vec3f up = floor.up;
  const float camera = floor.known ? floor.camera_height_mm : 0.0F;
  expected_count_ = 0;
  for (int t = 0; t < track_count_; ++t) {
    const Track& track = tracks_[at(t)];
    if (!track.confirmed || track.hidden_s > kExpectedMaxS) continue;
    expected_[at(expected_count_++)] = track.expected_mm + track.speed_mm_s * seconds + up * (track.top_mm - camera);
  }
}

void PersonTracker::list_keepouts(const Blobs& found) {
  keepout_count_ = 0;
  const auto of = [](const Blob& blob) { return Keepout{blob.c_min, blob.c_max, blob.centroid_mm.z}; };
  for (int t = 0; t < track_count_; ++t) {
    Track& track = tracks_[at(t)];
    if (track.detection >= 0) track.keepout = of(found.list()[at(detections_[at(track.detection)].blob)]);
    keepouts_[at(keepout_count_++)] = track.keepout;
  }
  for (const Blob& blob : found.list())
    if (blob.person_sized && keepout_count_ < kKeepoutCountMax) keepouts_[at(keepout_count_++)] = of(blob);
}

void PersonTracker::list_users(const Grid& grid, const Blobs& found) {
  for (int i = 0; i < detection_count_; ++i) {
    const BlobDetection& s = detections_[at(i)];
    const Track& track = tracks_[at(s.track)];
    const Blob& blob = found.list()[at(s.blob)];
    User& user = users_[at(i)];
    user.id = track.id;
    user.u_min = blob.c_min * grid.step;
    user.v_min = blob.r_min * grid.step;
    user.u_max = (blob.c_max + 1) * grid.step - 1;
    user.v_max = (blob.r_max + 1) * grid.step - 1;
    user.pixel_count = blob.cell_count * grid.step * grid.step;
    user.centroid_mm = blob.centroid_mm;
    user.head_mm = blob.has_head ? blob.head_mm : blob.centroid_mm + track.lean_mm;
    user.has_head = blob.has_head;
    user.visible_share = track.area_m2 > 0 ? std::min(1.0F, blob.area_m2 / track.area_m2) : 1.0F;
    user.confirmed = track.confirmed;
  }
}

}  // namespace im2fit
