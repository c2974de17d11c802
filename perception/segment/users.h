// SPDX-License-Identifier: Apache-2.0
// Who is who from frame to frame: people keep their numbers while they walk past one another.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "perception/segment/background.h"
#include "perception/segment/blobs.h"
#include "perception/segment/grid.h"

namespace im2fit::segment {

class UserTracker {
 public:
  void reset();  // forgets all users; ids go on
  // Gives the people among the blobs their ids. `seconds` since the frame before.
  void run(const Grid& grid, const BlobFinder& found, const FloorPlane& floor, float seconds);
  std::span<const User> users() const { return {users_.data(), static_cast<std::size_t>(user_count_)}; }
  int blob_of(std::size_t user) const { return user_blobs_[user]; }
  // A candidate: not confirmed, but seen often enough, and not shaped like furniture.
  bool is_candidate(std::size_t user) const { return user_candidates_[user]; }
  float shape_odds(int id) const;  // mean over the last frames; 0: unknown
  void confirm(int id);            // it is a person
  // Crowns of the people seen within the last second, where they should be by now.
  std::span<const Vec3f> expected() const { return {expected_.data(), static_cast<std::size_t>(expected_count_)}; }
  // Where people are, or were when last seen, and what has a person's size; until the next run.
  std::span<const Keepout> keepouts() const { return {keepouts_.data(), static_cast<std::size_t>(keepout_count_)}; }

 private:
  static constexpr int kTrackCountMax = 16;
  static constexpr int kKeepoutCountMax = 32;
  struct Track {
    int id = 0;
    Vec3f seen_mm;      // where last seen, along the floor (no component along up)
    Vec3f expected_mm;  // where by now, at the speed it had
    Vec3f speed_mm_s;
    float top_mm = 0;  // height of the crown
    bool has_top = false;
    float hidden_s = 0;
    int evidence = 0;  // that it is a person: 4 for a frame that shows one, -1 for one that does not
    bool confirmed = false;
    int chances = 0;  // that it might be one: counted as evidence is
    float shape_odds = 0;
    int shape_frames = 0;  // it is the mean of, kShapeFramesMax at most
    float area_m2 = 0;     // the most seen of it, slowly forgotten
    Vec3f lean_mm;         // from the centroid to the crown, along the floor
    float headless_s = 0;  // since its head was seen
    Keepout keepout;       // where last seen
    int detection = -1;    // of this frame
  };
  struct BlobDetection {
    int blob = -1;
    Vec3f place_mm;     // of the head, or of the centroid where there is none; along the floor
    Vec3f centroid_mm;  // along the floor
    float top_mm = 0;
    bool has_head = false;
    bool has_top = false;
    int track = -1;
  };

  void list_detections(const BlobFinder& found, const FloorPlane& floor);
  static BlobDetection describe(const Blob& blob, int index, const FloorPlane& floor);
  void match();
  void find_headless(const BlobFinder& found, const FloorPlane& floor);
  void list_candidates(const BlobFinder& found, const FloorPlane& floor);
  bool beside_person(Vec3f place_mm) const;
  bool taken(int blob) const;
  static float cost(const Track& track, const BlobDetection& detection);
  static void note_shape(Track& track, const Blob* blob);  // null: not seen
  static void follow(Track& track, const BlobDetection& detection, const Blob& blob, float seconds);
  Track& new_track();
  void list_users(const Grid& grid, const BlobFinder& found);
  void list_keepouts(const BlobFinder& found);
  void list_expected(const FloorPlane& floor, float seconds);

  std::array<Track, kTrackCountMax> tracks_;
  int track_count_ = 0;
  std::array<BlobDetection, kUserCountMax> detections_;
  int detection_count_ = 0;
  std::array<User, kUserCountMax> users_;
  std::array<int, kUserCountMax> user_blobs_{};
  std::array<bool, kUserCountMax> user_candidates_{};
  int user_count_ = 0;
  std::array<Vec3f, kTrackCountMax> expected_;
  int expected_count_ = 0;
  std::array<Keepout, kKeepoutCountMax> keepouts_;
  int keepout_count_ = 0;
  int id_last_ = 0;
  bool first_ = true;
};

}  // namespace im2fit::segment
