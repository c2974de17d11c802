// SPDX-License-Identifier: Apache-2.0
// Identities: one record for each person followed, from the first detection on for as long as it may stay hidden.
// A user begins unconfirmed. It is confirmed by its shape over some frames (Segmenter) or accepted by its joints
// (PersonDetector), or it is rejected as furniture; unconfirmed candidates stay selectable until rejected. Of all
// users one is followed in a frame: the nearest and most central, or the selected one. A session selects and holds
// the first person who stands correctly.
//
// Matching detections to records is person_matching.cpp; evidence and choice are person_tracker.cpp. No allocation,
// no threads; not shareable between threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/camera.h"
#include "core/floor_plane.h"
#include "core/floor_region.h"
#include "perception/segment/still_watch.h"

namespace im2fit {

namespace segment {
struct Blob;
struct Grid;
struct Blobs;
struct Head;

// Where the background is not learned: columns of cells, inclusive, and the depth at which a person stands.
struct Keepout {
  int c_min = 0, c_max = 0;
  float z_mm = 0;
};
}  // namespace segment

// Why one of the people of a frame is not measured. outside: of the region. still: a figure that stands as still as
// furniture while another one sways, such as a mannequin.
enum class LeftOut : std::uint8_t { no, outside, still };
inline constexpr std::array<std::string_view, 3> kLeftOutNames = {"no", "outside", "still"};

// One of the people of a frame, as the coarse picture shows them (cells of 4 px at 640x480).
struct User {
  int id = 0;  // >= 1; stays while the person is seen, or hidden for 5 s at most; never given to another person
  int u_min = 0, v_min = 0, u_max = -1, v_max = -1;  // px, box, inclusive
  int pixel_count = 0;                               // of the cells
  Vec3f centroid_mm;                                 // of the cells
  Vec3f head_mm;            // crown, as the camera sees it; without has_head the topmost cell seen last
  bool has_head = false;    // a head is seen in this frame
  float visible_share = 1;  // of the surface seen of this person at best, 0..1: less behind others
  bool confirmed = false;   // a person in three frames or in the first, and in a fifth of those since
  LeftOut left_out = LeftOut::no;
};
inline constexpr int kUserCountMax = 8;
namespace segment {
bool hides(const User& other, const User& user);  // the other stands before a part of the user
}

// Shorter flicker of the mask does not count as a loss: half a second, in frames at 30 Hz. The session uses the same.
inline constexpr int kAbsentPeriodsMax = 15;

// The evidence of one frame's joints for their owner being a person.
struct JointEvidence {
  float person_score = 0;    // JointTracker::person_score
  float odds = 0;            // log-odds that it is a person
  bool floor_known = false;  // without a floor furniture comes nearer to people
};

class PersonTracker {
 public:
  // Forgets all users and the session's; ids go on, and so does a selection by select().
  void reset();

  // The Segmenter's part of a frame.
  // Gives the people among the blobs their ids. `seconds` since the frame before.
  void follow(const segment::Grid& grid, const segment::Blobs& found, const FloorPlane& floor, float seconds);
  // The people of the last frame, at most kUserCountMax, nearest first; valid until the next follow() or reset().
  std::span<const User> users() const { return {users_.data(), static_cast<std::size_t>(detection_count_)}; }
  int blob_of(std::size_t user) const { return detections_[user].blob; }
  // Index of the user to look at, -1: none. The one of the last frame keeps an advantage, so that the choice does not
  // flicker.
  int choose() const;
  void look_at(int user);    // that index, in this frame; -1: none
  int people_count() const;  // confirmed
  // By another one, near enough to touch, hide or be taken for that index. Once it is said who is measured (select(),
  // or others are left out) those others disturb only by hiding the user.
  bool disturbed(int user) const;
  // Whether a head of this frame is outside the region, or of one who is left out.
  bool leaves_out(const segment::Head& head, const FloorPlane& floor) const;
  // Crowns of the people seen within the last second, where they should be in the next frame.
  std::span<const Vec3f> expected() const { return {expected_.data(), static_cast<std::size_t>(expected_count_)}; }
  // Places of people, now or when last seen, and of objects of a person's size; valid until the next follow().
  std::span<const segment::Keepout> keepouts() const {
    return {keepouts_.data(), static_cast<std::size_t>(keepout_count_)};
  }

  // The PersonDetector's part: is the followed user a person?
  // How much more that user's surface is shaped like a person's than like furniture, mean over the last frames:
  // log-odds, from -9 to 9; 0 for a user not seen whole or unknown.
  float shape_odds(int id) const;
  // A user accepted once stays accepted: people bend and turn away, and the joints then fit badly. The selected user
  // is not judged.
  bool accepted(int id) const;
  // Adds the joints' evidence: accept(), reject(), or neither while too few frames were judged. Returns accepted().
  bool judge(int id, const JointEvidence& evidence);
  void accept(int id);  // a person, and confirmed by this
  // Furniture: from the next frame on others are chosen before it, and it does not count as another person in view.
  // Until accept() or reset().
  void reject(int id);

  // The session's part.
  // From the next frame on follows only the user of this id, even while hidden or gone; never given up. 0 (default):
  // any user, and the session holds the first one who stands correctly. Ends a hold().
  void select(int id);
  int requested() const { return requested_; }  // by select()
  int selected() const { return selected_; }    // by select() or hold(), 0: anyone
  // From the next frame on only people whose feet are within are chosen; none: everywhere. Stays after reset().
  void set_region(const std::optional<FloorRegion>& region) { region_ = region; }
  // After each frame of a session: `shown` is the id of the user seen, 0: none; `ready`: that user stands correctly;
  // `periods` of 1/30 s passed since the frame before. From the first `ready` frame on only that user is selected,
  // until absent for more than kAbsentPeriodsMax: then the session is LOST, and the next user may begin one.
  void hold(int shown, bool ready, int periods = 1);
  void release() { select(requested_); }  // ends hold()

 private:
  static constexpr int kTrackCountMax = 16;
  static constexpr int kKeepoutCountMax = 32;
  // All that is known of one person.
  struct Track {
    int id = 0;
    // Where.
    Vec3f seen_mm;      // where last seen, along the floor (no component along up)
    Vec3f expected_mm;  // where by now, at the speed it had
    Vec3f speed_mm_s;
    float top_mm = 0;  // height of the crown
    bool has_top = false;
    float hidden_s = 0;
    float area_m2 = 0;         // the most seen of it, slowly forgotten
    Vec3f lean_mm;             // from the centroid to the crown, along the floor
    float headless_s = 0;      // since its head was seen
    segment::Keepout keepout;  // where last seen
    int detection = -1;        // of this frame
    // Whether it is a person, by its shape.
    int evidence = 0;  // 4 for a frame that shows one, -1 for one that does not
    bool confirmed = false;
    int chances = 0;  // that it might be one: counted as evidence is
    float shape_odds = 0;
    int shape_frames = 0;  // it is the mean of, kShapeFramesMax at most
    // And by its joints.
    int judged_frames = 0;
    float joint_odds_sum = 0;  // of the latest kLongFrames of them
    bool accepted = false;
    bool rejected = false;
    // Whether it is left out.
    bool has_swayed = false;  // it was seen to
    segment::StillWatch watch;
    LeftOut left_out = LeftOut::no;
    bool judged_place = false;
  };
  // users_[i] is the public part of detections_[i].
  struct BlobDetection {
    int blob = -1;
    Vec3f place_mm;     // of the head, or of the centroid where there is none; along the floor
    Vec3f centroid_mm;  // along the floor
    float top_mm = 0;
    bool has_head = false;
    bool has_top = false;
    int track = -1;
  };

  // person_matching.cpp
  void list_detections(const segment::Blobs& found, const FloorPlane& floor);
  static BlobDetection describe(const segment::Blob& blob, int index, const FloorPlane& floor);
  void match();
  void find_headless(const segment::Blobs& found, const FloorPlane& floor);
  void list_candidates(const segment::Blobs& found, const FloorPlane& floor);
  bool beside_person(Vec3f place_mm) const;
  bool taken(int blob) const;
  static float cost(const Track& track, const BlobDetection& detection);
  static void move(Track& track, const BlobDetection& detection, const segment::Blob& blob, float seconds);
  void continue_tracks(const segment::Blobs& found, float seconds);
  void begin_tracks(const segment::Blobs& found);
  Track& new_track();
  void list_users(const segment::Grid& grid, const segment::Blobs& found);
  void list_keepouts(const segment::Blobs& found);
  void list_expected(const FloorPlane& floor, float seconds);

  // left_out.cpp
  void leave_out(const segment::Grid& grid, const segment::Blobs& found, const FloorPlane& floor, float seconds);
  bool outside(const Track& track, const segment::Grid& grid, const segment::Blobs& found, const FloorPlane& floor,
               int blob) const;
  void watch(const segment::Grid& grid, const segment::Blobs& found, int user, float seconds);
  bool sways(int user) const;

  // person_tracker.cpp
  static void begin_evidence(Track& track, const segment::Blob& blob, bool first_frame);
  static void add_evidence(Track& track, const segment::Blob& blob);
  static float latest_share(const Track& track);  // of the evidence, 0..1: what a frame more would be
  static void note_shape(Track& track, const segment::Blob* blob);  // null: not seen
  static bool judged_person(Track& track, const JointEvidence& evidence);
  static bool judged_enough(const Track& track);
  static float mean_joint_odds(const Track& track);
  static bool is_candidate(const Track& track);
  const Track& track_of(std::size_t user) const;
  const Track* find(int id) const;
  Track* find(int id) { return const_cast<Track*>(static_cast<const PersonTracker*>(this)->find(id)); }

  std::array<Track, kTrackCountMax> tracks_;
  int track_count_ = 0;
  std::array<BlobDetection, kUserCountMax> detections_;
  std::array<User, kUserCountMax> users_;
  int detection_count_ = 0;
  std::array<Vec3f, kTrackCountMax> expected_;
  int expected_count_ = 0;
  std::array<segment::Keepout, kKeepoutCountMax> keepouts_;
  int keepout_count_ = 0;
  int id_last_ = 0;
  bool first_ = true;
  int looked_at_ = 0;  // id, in the last frame; 0: none
  int requested_ = 0;
  int selected_ = 0;
  std::optional<FloorRegion> region_;
  int absent_periods_ = 0;  // in a row, of who is held
};

}  // namespace im2fit
