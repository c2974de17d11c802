// SPDX-License-Identifier: Apache-2.0
// PersonTracker's third part: who is left out, by place or because it stands still.
#include <algorithm>
#include <cmath>

#include "perception/segment/blobs.h"
#include "perception/segment/person_tracker.h"

// The thresholds of this file: what each bounds and where it comes from. Sources:
//   [sway]  40 pairs of two rendered people (tests/evaluation/company_test.cpp): within 2.3 s those without
//           sway spread by 0.2 to 0.8 mm, those with by 1.2 to 11
//   [rooms] chosen on synthetic rooms, no measurement on record
namespace im2fit::left_out_limits {

constexpr float kFeetMm = 300.0F;             // above the lowest cell: the feet; [rooms]
constexpr float kRegionMarginMm = 60.0F;      // who was within leaves the region only beyond it; [rooms]
constexpr float kTrunkHalfWidthMm = 110.0F;   // about the middle, where the trunk is watched; [sway]
constexpr float kTrunkHalfHeightMm = 300.0F;  // above and below; [sway]
constexpr int kTrunkCellsMin = 100;           // least, to watch it; [sway]
constexpr int kHiddenParts = 4;               // one for so many of them may be hidden by an arm; [sway]
constexpr float kStillMm = 0.9F;              // spread of what stands still, most; [sway]
constexpr float kSwayMm = 3.0F;               // spread of who sways, least; [sway]
constexpr float kSwayShare = 3.0F;            // and so many times the still one's; [sway]
constexpr float kMovedMm = 2.2F;              // spread at which one left out as still is taken back; [sway]
constexpr float kHidesNearerMm = 100.0F;      // nearer than the user, least, to stand before; [rooms]
constexpr float kHidesShare = 0.15F;          // of the user's width, least; [rooms]

}  // namespace im2fit::left_out_limits

namespace im2fit {

using namespace left_out_limits;
using segment::at;
using segment::Blob;
using segment::Blobs;
using segment::Grid;

bool segment::hides(const User& other, const User& user) {
  if (other.centroid_mm.z > user.centroid_mm.z - kHidesNearerMm) return false;
  const int both = std::min(other.u_max, user.u_max) - std::max(other.u_min, user.u_min) + 1;
  return static_cast<float>(both) > kHidesShare * static_cast<float>(user.u_max - user.u_min + 1);
}

namespace {

struct FloorPoint {
  float x_mm = 0, z_mm = 0;
};

// Of the camera's axes, along the floor: z away from the camera, x to its right.
FloorPoint on_floor(Vec3f p, const FloorPlane& floor) {
  const Vec3f up = floor.up;
  const Vec3f ahead = Vec3f{0, 0, 1} - up * up.z;
  const float length = norm(ahead);
  if (!(length > 0.1F)) return {p.x, p.z};  // the camera looks straight down
  const Vec3f forward = ahead * (1.0F / length);
  return {dot(cross(forward, up), p), dot(forward, p)};
}

// The middle of the lowest cells.
Vec3f feet_of(const Grid& grid, const Blobs& found, int b) {
  const Blob& blob = found.blobs[at(b)];
  const auto label = static_cast<std::uint16_t>(b + 1);
  Vec3f sum;
  int count = 0;
  for (int r = blob.r_min; r <= blob.r_max; ++r) {
    for (int c = blob.c_min; c <= blob.c_max; ++c) {
      const auto i = at(grid.index(c, r));
      if (found.labels[i] != label || grid.height_mm[i] > blob.height_min_mm + kFeetMm) continue;
      sum = sum + grid.point(c, r);
      ++count;
    }
  }
  return count > 0 ? sum * (1.0F / static_cast<float>(count)) : blob.centroid_mm;
}

}  // namespace

bool PersonTracker::outside(const Track& track, const Grid& grid, const Blobs& found, const FloorPlane& floor,
                            int blob) const {
  if (!region_) return false;
  const FloorPoint feet = on_floor(feet_of(grid, found, blob), floor);
  const bool was_within = track.judged_place && track.left_out != LeftOut::outside;
  return !region_->holds(feet.x_mm, feet.z_mm, was_within ? kRegionMarginMm : 0.0F);
}

bool PersonTracker::leaves_out(const segment::Head& head, const FloorPlane& floor) const {
  const FloorPoint place = on_floor(head.top_mm, floor);
  if (region_ && !region_->holds(place.x_mm, place.z_mm)) return true;
  for (int i = 0; i < detection_count_; ++i)
    if (users_[at(i)].left_out != LeftOut::no && detections_[at(i)].blob == head.blob) return true;
  return false;
}

void PersonTracker::watch(const Grid& grid, const Blobs& found, int user, float seconds) {
  Track& track = tracks_[at(detections_[at(user)].track)];
  const Vec3f middle = track.watch.place_mm(users_[at(user)].centroid_mm);
  const float cells_a_mm = 1.0F / cell_mm(grid, middle.z);
  const int c = static_cast<int>((middle.x / middle.z * grid.intrinsics.fx + grid.intrinsics.cx) /
                                 static_cast<float>(grid.step));
  const int r = static_cast<int>((middle.y / middle.z * grid.intrinsics.fy + grid.intrinsics.cy) /
                                 static_cast<float>(grid.step));
  const int across = static_cast<int>(kTrunkHalfWidthMm * cells_a_mm);
  const int down = static_cast<int>(kTrunkHalfHeightMm * cells_a_mm);
  const int c_first = std::max(0, c - across), c_last = std::min(grid.width - 1, c + across);
  const int r_first = std::max(0, r - down), r_last = std::min(grid.height - 1, r + down);
  const auto label = static_cast<std::uint16_t>(detections_[at(user)].blob + 1);
  std::int64_t sum = 0;
  int count = 0;
  int others = 0;
  for (int row = r_first; row <= r_last; ++row) {
    const auto first = at(grid.index(0, row));
    for (int col = c_first; col <= c_last; ++col) {
      const auto i = first + at(col);
      if (found.labels[i] == label) {
        sum += grid.depth[i];
        ++count;
      } else {
        others += grid.depth[i] != 0 && static_cast<float>(grid.depth[i]) < middle.z - kHidesNearerMm ? 1 : 0;
      }
    }
  }
  // What another one hides in part seems to move as that one does.
  if (count >= kTrunkCellsMin && others * kHiddenParts <= count)
    track.watch.add(static_cast<float>(static_cast<double>(sum) / count), seconds);
}

bool PersonTracker::sways(int user) const {
  const Track& track = track_of(at(user));
  return track.confirmed && !track.rejected && track.watch.watched_long() && track.watch.spread_mm() >= kSwayMm;
}

// Nothing tells a mannequin from a person but that it never moves. That shows only beside another one who does: then
// the camera's noise is known to be less.
void PersonTracker::leave_out(const Grid& grid, const Blobs& found, const FloorPlane& floor, float seconds) {
  float sway_mm = 0;
  for (int i = 0; i < detection_count_; ++i) {
    // Alone, too, who is left out is watched on, for a person who moves again counts again; and who holds the
    // session, for then it is known of later what they are.
    const Track& track = track_of(at(i));
    if (detection_count_ > 1 || track.left_out == LeftOut::still || track.id == selected_)
      watch(grid, found, i, seconds);
    if (sways(i)) sway_mm = std::max(sway_mm, track_of(at(i)).watch.spread_mm());
  }
  for (int i = 0; i < detection_count_; ++i) {
    Track& track = tracks_[at(detections_[at(i)].track)];
    const float spread_mm = track.watch.spread_mm();
    const bool was_still = track.left_out == LeftOut::still;
    const bool stands =
        track.watch.watched_long() && spread_mm <= kStillMm && sway_mm >= std::max(kSwayMm, kSwayShare * spread_mm);
    track.has_swayed = track.has_swayed || (track.watch.watched_long() && spread_mm >= kMovedMm);
    // Who walks off is watched from the beginning, and is a person until then. Who is selected by id, or whose the
    // session is, stands still as asked; but a mannequin that stood alone holds no session.
    const bool theirs = track.id == requested_ || (track.id == selected_ && track.has_swayed);
    const bool still = (stands || (was_still && track.watch.watched_long() && spread_mm < kMovedMm)) && !theirs;
    track.left_out = outside(track, grid, found, floor, detections_[at(i)].blob) ? LeftOut::outside
                     : still                                                     ? LeftOut::still
                                                                                 : LeftOut::no;
    track.judged_place = true;
    users_[at(i)].left_out = track.left_out;
  }
}

}  // namespace im2fit
