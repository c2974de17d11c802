// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/segment.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::add;
using room_test::Box;
using room_test::kKinectNoise;
using room_test::person_at;
using room_test::Picture;
using room_test::render;
using room_test::Scene;

GuidanceSet bit(Guidance g) {
  return static_cast<GuidanceSet>(g);
}

struct Answer {
  Person person;
  std::vector<std::uint8_t> mask;
};

Answer segment(const Picture& p, const Intrinsics& k) {
  Segmenter segmenter(p.width, p.height);
  PersonTracker people;
  Answer a;
  a.mask.assign(p.depth.size(), 7);
  a.person = segmenter.run(p.view(), k, people, MaskImage(a.mask.data(), p.width, p.height));
  return a;
}
Answer segment(const Scene& s, double noise = kKinectNoise) {
  return segment(render(s, noise), s.intrinsics());
}

double overlap(const Answer& a, const Picture& p, int owner) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < a.mask.size(); ++i) {
    const bool mine = a.mask[i] != 0, true_one = p.owner[i] == owner;
    both += mine && true_one ? 1 : 0;
    either += mine || true_one ? 1 : 0;
  }
  return either > 0 ? both / either : 0;
}

Scene standing(float z = 2600) {
  Scene s;
  s.wall_z = z + 900;
  add(s, person_at(0, z));
  return s;
}

struct FloorCase {
  float camera_height, pitch_deg, z;
};
class SegmentFloor : public testing::TestWithParam<FloorCase> {};

TEST_P(SegmentFloor, HeightAtTheFeetIsRight) {
  const FloorCase& c = GetParam();
  Scene s = standing(c.z);
  s.camera_height = c.camera_height;
  s.pitch_deg = c.pitch_deg;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Answer a = segment(render(s, kKinectNoise, seed), s.intrinsics());
    ASSERT_TRUE(a.person.floor.known);
    for (const float x : {-150.0F, 150.0F}) {
      const Vec3f foot = s.to_camera({x, 0, c.z - 100});
      EXPECT_NEAR(dot(a.person.floor.up, foot) + a.person.floor.camera_height_mm, 0, 3) << "x " << x;
    }
    EXPECT_GT(dot(a.person.floor.up, s.up_in_camera()), 0.99996F);  // half a degree
  }
}

INSTANTIATE_TEST_SUITE_P(Mountings, SegmentFloor,
                         testing::Values(FloorCase{1000, 0, 2500}, FloorCase{600, 0, 2500}, FloorCase{900, -8, 3000},
                                         FloorCase{1200, 12, 2200}, FloorCase{1800, 20, 2600},
                                         FloorCase{2100, 20, 3200}, FloorCase{2200, 28, 2700},
                                         FloorCase{2300, 35, 2200}, FloorCase{500, -6, 2600}));

TEST(Segment, MaskFollowsThePersonDownToTheFloor) {
  const Scene s = standing();
  const Picture p = render(s, kKinectNoise);
  const Answer a = segment(p, s.intrinsics());
  ASSERT_TRUE(a.person.found);
  EXPECT_EQ(a.person.people_count, 1);
  EXPECT_EQ(a.person.guidance, 0U);
  EXPECT_GT(overlap(a, p, 1), 0.97);
  float lowest = 1e9F;
  for (int v = 0; v < p.height; ++v)
    for (int u = 0; u < p.width; ++u)
      if (a.mask[static_cast<std::size_t>(v * p.width + u)] != 0)
        lowest = std::min(lowest, dot(s.up_in_camera(), unproject(s.intrinsics(), static_cast<float>(u),
                                                                  static_cast<float>(v), p.view().at(u, v))) +
                                      s.camera_height);
  EXPECT_LT(lowest, 15);
}

// The head is lower than a seated adult's, and larger for the body; legs are thinner than any adult's.
TEST(Segment, AChildOfAMetreIsFound) {
  constexpr float kScale = 0.59F, kHeadScale = 0.85F, kZ = 2400;
  std::vector<room_test::Capsule> child = room_test::person_at(0, kZ);
  for (room_test::Capsule& c : child) {
    c.radius *= &c < child.data() + 2 ? kHeadScale : kScale;  // head and neck
    for (Vec3f* p : {&c.a, &c.b}) *p = {p->x * kScale, p->y * kScale, kZ + (p->z - kZ) * kScale};
  }
  Scene s;
  s.camera_height = 1000;
  s.wall_z = 3400;
  room_test::add(s, child);
  const Picture p = render(s, kKinectNoise);
  const Answer a = segment(p, s.intrinsics());
  ASSERT_TRUE(a.person.found);
  EXPECT_EQ(a.person.people_count, 1);
  EXPECT_GT(overlap(a, p, 1), 0.9);
}

TEST(Segment, BoxCountAndCentroidDescribeTheMask) {
  const Scene s = standing();
  const Picture p = render(s);
  const Answer a = segment(p, s.intrinsics());
  int count = 0, u_min = 9999, v_min = 9999, u_max = -1, v_max = -1;
  double x = 0, y = 0, z = 0;
  for (int v = 0; v < p.height; ++v) {
    for (int u = 0; u < p.width; ++u) {
      const std::uint8_t m = a.mask[static_cast<std::size_t>(v * p.width + u)];
      ASSERT_TRUE(m == 0 || m == 255);
      if (m == 0) continue;
      const Vec3f q = unproject(s.intrinsics(), static_cast<float>(u), static_cast<float>(v), p.view().at(u, v));
      ++count;
      x += static_cast<double>(q.x);
      y += static_cast<double>(q.y);
      z += static_cast<double>(q.z);
      u_min = std::min(u_min, u);
      u_max = std::max(u_max, u);
      v_min = std::min(v_min, v);
      v_max = std::max(v_max, v);
    }
  }
  ASSERT_GT(count, 0);
  EXPECT_EQ(a.person.pixel_count, count);
  EXPECT_EQ(a.person.u_min, u_min);
  EXPECT_EQ(a.person.u_max, u_max);
  EXPECT_EQ(a.person.v_min, v_min);
  EXPECT_EQ(a.person.v_max, v_max);
  EXPECT_NEAR(a.person.centroid_mm.x, x / count, 0.1);
  EXPECT_NEAR(a.person.centroid_mm.y, y / count, 0.1);
  EXPECT_NEAR(a.person.centroid_mm.z, z / count, 0.1);
}

struct View {
  const char* name;
  Scene scene;
  bool found;
  GuidanceSet must;
};

std::vector<View> guidance_cases() {
  std::vector<View> out;
  Scene s = standing();
  out.push_back({"whole", s, true, 0});

  s = standing(4600);
  out.push_back({"far", s, true, bit(Guidance::too_far)});

  s = standing(1500);  // f 575.8: 1.67 m of height at 1.5 m
  s.camera_height = 1500;
  out.push_back({"feet", s, true, bit(Guidance::feet_cut)});

  s = standing(1700);
  s.camera_height = 700;
  out.push_back({"head", s, true, bit(Guidance::head_cut)});

  s = standing(2300);
  s.wall_z = 3600;
  s.capsules.clear();
  add(s, person_at(750, 2300));  // the picture ends at x = 959 mm there, the left hand at 1170
  out.push_back({"side", s, true, bit(Guidance::side_cut)});

  s = standing();
  add(s, person_at(-800, 3100, 2));
  s.wall_z = 4000;
  out.push_back({"two", s, true, bit(Guidance::several_people)});
  return out;
}

TEST(Segment, GuidanceSaysWhatIsWrong) {
  for (const View& c : guidance_cases()) {
    const Answer a = segment(c.scene);
    EXPECT_EQ(a.person.found, c.found) << c.name;
    EXPECT_EQ(a.person.guidance & c.must, c.must) << c.name << " " << a.person.guidance;
    if (c.must == 0) {
      EXPECT_EQ(a.person.guidance, 0U) << c.name;
    }
  }
}

TEST(Segment, TooNearIsReportedEvenWhenNothingResemblesAPerson) {
  Scene s;
  s.camera_height = 1300;
  s.wall_z = 2600;
  add(s, person_at(0, 750));
  EXPECT_TRUE(has(segment(s).person.guidance, Guidance::too_near));
}

TEST(Segment, HolesAreTooNoisy) {
  const Scene s = standing();
  Picture p = render(s, kKinectNoise);
  Rng rng(5);
  for (std::size_t i = 0; i < p.depth.size(); ++i)
    if (rng.uniform() < 0.45) p.depth[i] = 0;
  const Answer a = segment(p, s.intrinsics());
  EXPECT_TRUE(has(a.person.guidance, Guidance::too_noisy)) << a.person.guidance << " " << a.person.pixel_count;
  EXPECT_FALSE(has(segment(s).person.guidance, Guidance::too_noisy));
}

TEST(Segment, NoPersonInRoomsWithoutPeople) {
  Scene room;
  room.wall_z = 3500;
  Scene furnished = room;
  furnished.boxes = {{{-900, 0, 2400}, {-300, 1900, 2900}},  // cupboard
                     {{200, 700, 2300}, {1100, 740, 2900}},  // table top
                     {{500, 740, 2500}, {650, 1100, 2600}},  // a carton on it
                     {{-150, 0, 2000}, {150, 450, 2300}}};   // stool
  Scene pole = room;                                         // a hat over a coat on a stand
  pole.boxes = {{{-20, 0, 2680}, {20, 1750, 2720}}, {{-190, 850, 2620}, {190, 1610, 2780}}};
  pole.capsules = {{{0, 1790, 2700}, {0, 1791, 2700}, 100, 9}};
  Scene wall;
  wall.floor = false;
  wall.wall_z = 2500;
  Scene floor;
  floor.pitch_deg = 20;
  std::vector<std::pair<std::string, Scene>> scenes;
  scenes.emplace_back("room", room);
  scenes.emplace_back("furnished", furnished);
  scenes.emplace_back("pole", pole);
  scenes.emplace_back("wall", wall);
  scenes.emplace_back("floor", floor);
  for (const auto& [name, s] : scenes) {
    for (const double noise : {0.0, kKinectNoise}) {
      const Answer a = segment(s, noise);
      EXPECT_FALSE(a.person.found) << name << noise;
      EXPECT_EQ(a.person.people_count, 0) << name << noise;
      EXPECT_TRUE(has(a.person.guidance, Guidance::no_person)) << name << noise;
      for (const std::uint8_t m : a.mask) ASSERT_EQ(m, 0) << name;
    }
  }
}

TEST(Segment, EmptyAndSaturatedFramesShowNoPerson) {
  const Scene s;
  for (const std::uint16_t value : {std::uint16_t{0}, std::uint16_t{65535}, std::uint16_t{1}}) {
    Picture p;
    p.width = s.width;
    p.height = s.height;
    p.depth.assign(static_cast<std::size_t>(p.width * p.height), value);
    const Answer a = segment(p, s.intrinsics());
    EXPECT_FALSE(a.person.found) << value;
    EXPECT_FALSE(a.person.floor.known) << value;
    EXPECT_TRUE(has(a.person.guidance, Guidance::no_person)) << value;
  }
}

TEST(Segment, FurnitureBesideAndBehindStaysOutOfTheMask) {
  Scene s = standing();
  s.boxes = {{{450, 0, 2500}, {900, 760, 3000}},      // a chest 30 mm beside the hand
             {{-800, 700, 2300}, {-440, 740, 2900}},  // a table edge
             {{-300, 0, 2900}, {300, 1000, 3100}}};   // a box close behind the legs
  const Picture p = render(s, kKinectNoise);
  const Answer a = segment(p, s.intrinsics());
  ASSERT_TRUE(a.person.found);
  EXPECT_EQ(a.person.people_count, 1);
  EXPECT_GT(overlap(a, p, 1), 0.96);
}

TEST(Segment, AWallCloseBehindIsNotThePerson) {
  Scene s = standing(2400);
  s.wall_z = 2400 + 115 + 300;
  const Picture p = render(s, kKinectNoise);
  const Answer a = segment(p, s.intrinsics());
  ASSERT_TRUE(a.person.found);
  EXPECT_GT(overlap(a, p, 1), 0.96);
}

TEST(Segment, PeopleWhoseHandsTouchAreTwo) {
  Scene s;
  s.width = 640;
  s.height = 480;
  s.wall_z = 4200;
  add(s, person_at(-100, 3000, 1));
  add(s, person_at(640, 3000, 2));  // hands at 280 and 260
  const Picture p = render(s, kKinectNoise);
  const Answer a = segment(p, s.intrinsics());
  ASSERT_TRUE(a.person.found);
  EXPECT_EQ(a.person.people_count, 2);
  EXPECT_GT(overlap(a, p, 1), 0.93);  // the central one
}

TEST(Segment, TheNearerPersonIsChosen) {
  Scene s = standing(2300);
  add(s, person_at(-700, 3300, 2));
  s.wall_z = 4200;
  const Picture p = render(s, kKinectNoise);
  const Answer a = segment(p, s.intrinsics());
  EXPECT_GT(overlap(a, p, 1), 0.96);
}

TEST(Segment, BackgroundAlreadyRemoved) {
  Scene s = standing(1250);
  s.camera_height = 1350;
  Picture p = render(s, kKinectNoise);
  for (std::size_t i = 0; i < p.depth.size(); ++i)
    if (p.owner[i] != 1) p.depth[i] = 0;
  const Answer a = segment(p, s.intrinsics());
  ASSERT_TRUE(a.person.found);
  EXPECT_TRUE(has(a.person.guidance, Guidance::feet_cut));
  EXPECT_FALSE(a.person.floor.known);
  EXPECT_GT(overlap(a, p, 1), 0.98);
}

TEST(Segment, SmallLandscapeFramesWork) {
  Scene s = standing(2900);
  s.width = 320;
  s.height = 240;
  s.focal = 287.9F;
  const Picture p = render(s, kKinectNoise);
  const Answer a = segment(p, s.intrinsics());
  ASSERT_TRUE(a.person.found);
  EXPECT_EQ(a.person.guidance, 0U);
  EXPECT_GT(overlap(a, p, 1), 0.95);
}

TEST(Segment, ResetForgetsAndTheSameFramesGiveTheSameAnswer) {
  const Scene s = standing();
  const Picture first = render(s, kKinectNoise, 1), second = render(s, kKinectNoise, 2);
  const Intrinsics k = s.intrinsics();
  Segmenter segmenter(s.width, s.height);
  PersonTracker people;
  std::vector<std::uint8_t> a(first.depth.size()), b(first.depth.size());
  const Person cold = segmenter.run(second.view(), k, people, MaskImage(a.data(), s.width, s.height));
  segmenter.run(first.view(), k, people, MaskImage(b.data(), s.width, s.height));
  segmenter.reset();
  people.reset();
  const Person again = segmenter.run(second.view(), k, people, MaskImage(b.data(), s.width, s.height));
  EXPECT_EQ(a, b);
  EXPECT_EQ(cold.floor.camera_height_mm, again.floor.camera_height_mm);
  EXPECT_EQ(cold.centroid_mm.x, again.centroid_mm.x);
}

TEST(Segment, AMovedCameraIsFollowed) {
  Scene s = standing();
  const Intrinsics k = s.intrinsics();
  Segmenter segmenter(s.width, s.height);
  PersonTracker people;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(s.width * s.height));
  for (std::uint64_t i = 0; i < 5; ++i)
    segmenter.run(render(s, kKinectNoise, i).view(), k, people, MaskImage(mask.data(), s.width, s.height));
  s.camera_height = 1300;
  s.pitch_deg = 6;
  Person person;
  for (std::uint64_t i = 0; i < 2; ++i)
    person = segmenter.run(render(s, kKinectNoise, i).view(), k, people, MaskImage(mask.data(), s.width, s.height));
  ASSERT_TRUE(person.floor.known);
  EXPECT_NEAR(person.floor.camera_height_mm, 1300, 12);
}

}  // namespace
}  // namespace im2fit
