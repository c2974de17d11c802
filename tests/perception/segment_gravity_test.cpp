// SPDX-License-Identifier: Apache-2.0
// Uses of gravity: a tilted camera that sees no floor, and planes that are not a floor.
#include <gtest/gtest.h>

#include "perception/segment/segment.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::add;
using room_test::kKinectNoise;
using room_test::person_at;
using room_test::Picture;
using room_test::render;
using room_test::Scene;

Person person_in(const Scene& s, const std::optional<Vec3f>& up) {
  const Picture p = render(s, kKinectNoise);
  Segmenter segmenter(p.width, p.height);
  PersonTracker people;
  std::vector<std::uint8_t> mask(p.depth.size());
  return segmenter.run(p.view(), s.intrinsics(), people, MaskImage(mask.data(), p.width, p.height), 1.0F / 30, up);
}

Scene tilted(float pitch_deg, bool floor) {
  Scene s;
  s.pitch_deg = pitch_deg;
  s.camera_height = pitch_deg > 0 ? 1500.0F : 900.0F;
  s.floor = floor;
  add(s, person_at(0, 2600));
  return s;
}

TEST(SegmentGravity, SaysWhatIsUpWhereNoFloorIsSeen) {
  for (const float pitch_deg : {-10.0F, 15.0F, 22.0F}) {
    const Scene s = tilted(pitch_deg, false);
    const Person with = person_in(s, s.up_in_camera());
    ASSERT_TRUE(with.found) << pitch_deg;
    EXPECT_FALSE(with.floor.known);
    EXPECT_EQ(norm(with.floor.up - s.up_in_camera()), 0.0F);
    const Person without = person_in(s, std::nullopt);
    EXPECT_FALSE(without.floor.known);
    EXPECT_EQ(norm(without.floor.up - Vec3f{0, -1, 0}), 0.0F) << "the picture's vertical";
  }
}

TEST(SegmentGravity, LeavesAFloorThatIsSeenAlone) {
  for (const float pitch_deg : {-5.0F, 0.0F, 15.0F}) {
    const Scene s = tilted(pitch_deg, true);
    const Person with = person_in(s, s.up_in_camera()), without = person_in(s, std::nullopt);
    ASSERT_TRUE(without.floor.known) << pitch_deg;
    ASSERT_TRUE(with.floor.known) << pitch_deg;
    EXPECT_GT(dot(with.floor.up, without.floor.up), 0.99999F);
    EXPECT_NEAR(with.floor.camera_height_mm, without.floor.camera_height_mm, 5);
  }
}

TEST(SegmentGravity, RefusesAPlaneThatIsNotLevel) {
  Scene s = tilted(0, true);
  ASSERT_TRUE(person_in(s, std::nullopt).floor.known);
  Scene sloped = s;
  sloped.pitch_deg = 12;  // what gravity would be if that plane were a ramp
  EXPECT_FALSE(person_in(s, sloped.up_in_camera()).floor.known);
  sloped.pitch_deg = 3;  // a phone's accelerometer, a little off
  EXPECT_TRUE(person_in(s, sloped.up_in_camera()).floor.known);
}

}  // namespace
}  // namespace im2fit
