// SPDX-License-Identifier: Apache-2.0
// What the segmenter keeps from frame to frame, floor and wall, while nothing moves, and that it lets go of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "perception/segment/segment.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using namespace room_test;

constexpr float kPersonZ = 2600;

Scene room(float camera_height, float pitch_deg, float wall_z = kPersonZ + 900) {
  Scene s;
  s.width = 240;
  s.height = 320;
  s.focal = 287.9F;
  s.camera_height = camera_height;
  s.pitch_deg = pitch_deg;
  s.wall_z = wall_z;
  add(s, person_at(0, kPersonZ));
  return s;
}

class Watcher {
 public:
  explicit Watcher(const Scene& s)
      : segmenter_(s.width, s.height),
        mask_(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height)) {}
  Person see(const Scene& s, int frames) {
    Person person;
    for (int i = 0; i < frames; ++i) {
      picture_ = render(s, kKinectNoise, ++seed_);
      person = segmenter_.run(picture_.view(), s.intrinsics(), people_, MaskImage(mask_.data(), s.width, s.height));
    }
    return person;
  }
  // Of the mask's pixels, the share that is the person's.
  double own_share() const {
    double own = 0, all = 0;
    for (std::size_t i = 0; i < mask_.size(); ++i) {
      all += mask_[i] != 0 ? 1 : 0;
      own += mask_[i] != 0 && picture_.owner[i] == 1 ? 1 : 0;
    }
    return own / std::max(all, 1.0);
  }

 private:
  Segmenter segmenter_;
  PersonTracker people_;
  std::vector<std::uint8_t> mask_;
  Picture picture_;
  std::uint64_t seed_ = 0;
};

// Height of a foot above the floor found, mm: 0 is right.
float foot_height_mm(const Scene& s, const Person& person) {
  const Vec3f foot = s.to_camera({150, 0, kPersonZ - 100});
  return dot(person.floor.up, foot) + person.floor.camera_height_mm;
}

TEST(SegmentReuse, FloorStaysRightOverManyFrames) {
  for (const float pitch_deg : {0.0F, 12.0F}) {
    const Scene s = room(1100, pitch_deg);
    Watcher watcher(s);
    watcher.see(s, 12);
    for (int part = 0; part < 8; ++part) {
      const Person person = watcher.see(s, 3);
      ASSERT_TRUE(person.floor.known);
      EXPECT_NEAR(foot_height_mm(s, person), 0, 3) << pitch_deg << " degrees, part " << part;
      EXPECT_GT(dot(person.floor.up, s.up_in_camera()), 0.99998F);
    }
  }
}

// Up, down and tilted, by amounts that one frame cannot hide and by amounts that it can.
TEST(SegmentReuse, CameraThatMovesLeavesTheFloor) {
  const Scene before = room(1100, 4);
  for (const Scene& after : {room(1140, 4), room(1060, 4), room(1115, 4), room(1100, 5), room(1100, 3.5F)}) {
    Watcher watcher(before);
    watcher.see(before, 25);
    const Person person = watcher.see(after, 20);
    ASSERT_TRUE(person.floor.known);
    EXPECT_NEAR(foot_height_mm(after, person), 0, 4) << after.camera_height << " mm, " << after.pitch_deg;
  }
}

// The wall comes nearer, as when the camera is carried to another place: the rest of the wall is not the person's.
TEST(SegmentReuse, WallThatMovesIsFoundAnew) {
  const Scene before = room(1100, 4, kPersonZ + 1500);
  for (const float wall_z : {kPersonZ + 700, kPersonZ + 1300, kPersonZ + 2200}) {
    const Scene after = room(1100, 4, wall_z);
    Watcher watcher(before);
    watcher.see(before, 5);
    const Person person = watcher.see(after, 1);
    ASSERT_TRUE(person.found) << wall_z;
    EXPECT_GT(watcher.own_share(), 0.95) << wall_z;
  }
}

}  // namespace
}  // namespace im2fit
