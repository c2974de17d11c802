// SPDX-License-Identifier: Apache-2.0
// Furniture that is one surface with a person, furniture that resembles one, and people who hardly do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "perception/segment/segment.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::add;
using room_test::Box;
using room_test::Capsule;
using room_test::kKinectNoise;
using room_test::person_at;
using room_test::Picture;
using room_test::render;
using room_test::Scene;

struct Shares {
  double overlap = 0;    // of the true mask and ours, over both
  double furniture = 0;  // of our mask
  bool found = false;
};

// Of the first frame: nothing is known before.
Shares first_frame(const Scene& s, std::uint64_t seed = 1) {
  const Picture p = render(s, kKinectNoise, seed);
  std::vector<std::uint8_t> mask(p.depth.size());
  Segmenter segmenter(s.width, s.height);
  PersonTracker people;
  const Person person = segmenter.run(p.view(), s.intrinsics(), people, MaskImage(mask.data(), s.width, s.height));
  double both = 0, either = 0, ours = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const bool mine = mask[i] != 0, true_one = p.owner[i] == 1;
    both += mine && true_one ? 1 : 0;
    either += mine || true_one ? 1 : 0;
    ours += mine ? 1 : 0;
  }
  return {either > 0 ? both / either : 0, ours > 0 ? 1 - both / ours : 0, person.found};
}

Scene room_with(const std::vector<Capsule>& person, std::vector<Box> boxes = {}) {
  Scene s;
  s.wall_z = 4200;
  s.camera_height = 1100;
  s.pitch_deg = 4;
  s.boxes = std::move(boxes);
  add(s, person);
  return s;
}

// The right shin of person_at stands 60 to 170 mm beside the middle, 50 mm about its axis.
TEST(SegmentFurniture, ABoxAtTheLegIsNotThePerson) {
  for (const float side : {-1.0F, 1.0F}) {
    const float near = side * 165, far = side * 465;
    const Box box = {{std::min(near, far), 0, 2590}, {std::max(near, far), 420, 2890}};
    const Shares s = first_frame(room_with(person_at(0, 2600), {box}));
    ASSERT_TRUE(s.found);
    EXPECT_LT(s.furniture, 0.04) << side;
    EXPECT_GT(s.overlap, 0.95) << side;
  }
}

TEST(SegmentFurniture, ACupboardThatAHandTouchesIsNotThePerson) {
  for (const float side : {-1.0F, 1.0F}) {
    const float near = side * 405, far = side * 800;
    const Box box = {{std::min(near, far), 0, 2570}, {std::max(near, far), 900, 2870}};
    const Shares s = first_frame(room_with(person_at(0, 2600), {box}));
    ASSERT_TRUE(s.found);
    EXPECT_LT(s.furniture, 0.04) << side;
    EXPECT_GT(s.overlap, 0.95) << side;
  }
}

// Legs apart and arms out reach as far, but not from the floor up.
TEST(SegmentFurniture, LegsApartAndArmsOutStay) {
  std::vector<Capsule> person = person_at(0, 2900);
  for (Capsule& part : person) {
    const auto spread = [](Vec3f& p) { p.x += (p.x < 0 ? -1.0F : 1.0F) * std::max(0.0F, 0.6F * (900 - p.y)); };
    if (part.a.y <= 900 && std::fabs(part.a.x) < 150) spread(part.a), spread(part.b);
    if (part.a.y > 1000 && part.b.y < 1200 && std::fabs(part.b.x) > 200)
      part.a.y = part.b.y = 1380, part.b.x *= 1.6F, part.a.x *= part.a.x > 200 || part.a.x < -200 ? 1.6F : 1.0F;
  }
  const Shares s = first_frame(room_with(person));
  ASSERT_TRUE(s.found);
  EXPECT_GT(s.overlap, 0.95);
}

// Bent forward by 55 degrees about the hips: no taller than who sits, but nothing of it is a chair.
TEST(SegmentFurniture, WhoBendsDownKeepsTheLegs) {
  constexpr float kSine = 0.82F, kCosine = 0.57F, kHips = 930;
  std::vector<Capsule> bent;
  for (Capsule c : person_at(0, 2800)) {
    const bool leg = std::min(c.a.y, c.b.y) < 840 && std::max(c.a.y, c.b.y) <= 900;
    for (Vec3f* end : {&c.a, &c.b}) {
      const float up = end->y - kHips;
      if (!leg) *end = {end->x, kHips + kCosine * up, end->z - kSine * up};
    }
    bent.push_back(c);
  }
  const Shares s = first_frame(room_with(bent));
  ASSERT_TRUE(s.found);
  EXPECT_GT(s.overlap, 0.95);
}

TEST(SegmentFurniture, ABoxBetweenTheLegsIsNotThePerson) {
  std::vector<Capsule> wide;
  for (Capsule c : person_at(0, 2600)) {
    for (Vec3f* end : {&c.a, &c.b})  // legs apart, 150 mm more at the floor
      if (end->y < 900) end->x *= 1.0F + 1.2F * (900 - end->y) / 900;
    wide.push_back(c);
  }
  const Shares s = first_frame(room_with(wide, {{{-160, 0, 2600}, {160, 330, 2850}}}));
  ASSERT_TRUE(s.found);
  EXPECT_LT(s.furniture, 0.03);
  EXPECT_GT(s.overlap, 0.94);
}

TEST(SegmentFurniture, NothingOfAPersonWithoutFurnitureIsCut) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Shares s = first_frame(room_with(person_at(0, 2600)), seed);
    ASSERT_TRUE(s.found);
    EXPECT_GT(s.overlap, 0.96) << seed;
  }
}

// 1.25 m tall as she sits: knees 480 mm up and 420 mm before the hips.
std::vector<Capsule> seated_at(float x, float z) {
  const auto at = [&](float dx, float y, float dz = 0) { return Vec3f{x + dx, y, z + dz}; };
  std::vector<Capsule> c = {{at(0, 1130), at(0, 1170), 90, 1},    {at(0, 980), at(0, 1100), 55, 1},
                            {at(-120, 900), at(120, 900), 75, 1}, {at(0, 560), at(0, 860), 120, 1},
                            {at(-75, 560), at(-80, 870), 100, 1}, {at(75, 560), at(80, 870), 100, 1}};
  for (const float s : {-1.0F, 1.0F}) {
    c.push_back({at(s * 175, 890), at(s * 230, 640, -60), 45, 1});
    c.push_back({at(s * 230, 640, -60), at(s * 110, 570, -260), 38, 1});
    c.push_back({at(s * 90, 520), at(s * 150, 490, -420), 70, 1});
    c.push_back({at(s * 150, 470, -430), at(s * 155, 80, -430), 52, 1});
    c.push_back({at(s * 155, 40, -420), at(s * 165, 35, -560), 35, 1});
  }
  return c;
}

// A seat 70 mm thick with four legs and a back; the person's back touches it.
std::vector<Box> chair_at(float x, float z) {
  std::vector<Box> boxes = {{{x - 230, 370, z - 350}, {x + 230, 440, z + 140}},
                            {{x - 230, 560, z + 150}, {x + 230, 900, z + 180}}};
  for (const float s : {-1.0F, 1.0F}) {
    const float leg = x + s * 210;
    boxes.push_back({{leg - 18, 0, z - 350}, {leg + 18, 370, z - 314}});
    boxes.push_back({{leg - 18, 0, z + 144}, {leg + 18, 900, z + 180}});
  }
  return boxes;
}

TEST(SegmentFurniture, TheChairIsNotWhoSitsOnIt) {
  const Shares s = first_frame(room_with(seated_at(0, 2700), chair_at(0, 2700)));
  ASSERT_TRUE(s.found);
  EXPECT_LT(s.furniture, 0.03);
  EXPECT_GT(s.overlap, 0.94);
}

// A fifth larger all over: 1.51 m tall as he sits, as others are who stand.
TEST(SegmentFurniture, TheTallestSitAsWell) {
  std::vector<Capsule> person = seated_at(0, 0);
  for (Capsule& c : person) {
    for (Vec3f* end : {&c.a, &c.b}) *end = *end * 1.2F + Vec3f{0, 0, 2700};
    c.radius *= 1.2F;
  }
  std::vector<Box> chair = chair_at(0, 0);
  for (Box& b : chair)
    for (Vec3f* end : {&b.low, &b.high}) *end = *end * 1.2F + Vec3f{0, 0, 2700};
  const Shares s = first_frame(room_with(person, chair));
  ASSERT_TRUE(s.found);
  EXPECT_LT(s.furniture, 0.03);
  EXPECT_GT(s.overlap, 0.94);
}

// One ankle is 40 mm wide, as legs of chairs are, for 30 mm.
TEST(SegmentFurniture, FeetBelowThinAnklesStay) {
  std::vector<Capsule> person = seated_at(0, 2700);
  for (Capsule& c : person) {
    if (c.radius != 52) continue;  // shins
    const float x = c.a.x;
    c.b = {x, 300, c.a.z};
    person.push_back({{x, 270, c.a.z}, {x, 240, c.a.z}, 20, 1});
    person.push_back({{x, 200, c.a.z}, {x, 60, c.a.z}, 48, 1});
    break;
  }
  const Shares s = first_frame(room_with(person, chair_at(0, 2700)));
  ASSERT_TRUE(s.found);
  EXPECT_LT(s.furniture, 0.03);
  EXPECT_GT(s.overlap, 0.95);
}

// As far as the shins and beside them, so that they are one surface.
TEST(SegmentFurniture, LegsOfChairsAreThinnerThanShins) {
  std::vector<Box> boxes;
  for (const float x : {-265.0F, 265.0F}) {
    boxes.push_back({{x - 15, 0, 2250}, {x + 15, 600, 2280}});
    boxes.push_back({{x - 15, 570, 2250}, {x + 15, 600, 2700}});  // under the forearm
  }
  const Shares s = first_frame(room_with(seated_at(0, 2700), boxes));
  ASSERT_TRUE(s.found);
  EXPECT_LT(s.furniture, 0.03);
  EXPECT_GT(s.overlap, 0.94) << "the shins stay";
}

// The head hides where the trunk begins: that is an edge as well, once the head is gone.
TEST(SegmentFurniture, ABoxBehindAnotherBoxAtTheLegIsNotThePerson) {
  const Shares s = first_frame(
      room_with(person_at(0, 2600), {{{165, 180, 2560}, {400, 520, 3000}}, {{215, 500, 2390}, {350, 740, 2561}}}));
  ASSERT_TRUE(s.found);
  EXPECT_LT(s.furniture, 0.03);
  EXPECT_GT(s.overlap, 0.94);
}

// In profile, a leg behind the other, forearms crossed before and above the head: neither head nor legs to be seen.
std::vector<Capsule> hidden_head_at(float x, float z) {
  const auto at = [&](float dx, float y, float dz = 0) { return Vec3f{x + dx, y, z + dz}; };
  return {{at(0, 1560), at(0, 1610), 90, 1},
          {at(0, 1350), at(0, 1540), 65, 1},
          {at(0, 1240), at(0, 1300), 140, 1},
          {at(-20, 1060), at(-20, 1090), 130, 1},
          {at(10, 900), at(10, 930), 150, 1},
          {at(10, 760), at(10, 770), 100, 1},
          {at(5, 620), at(5, 640), 85, 1},
          {at(0, 480), at(0, 500), 70, 1},
          {at(-5, 330), at(-5, 360), 75, 1},
          {at(-5, 330), at(-20, 80), 50, 1},
          {at(40, 800, 60), at(60, 480, 100), 75, 1},
          {at(60, 480, 100), at(130, 80, 120), 50, 1},
          {at(-10, 40), at(-150, 35), 35, 1},
          {at(0, 1380, -90), at(-190, 1480, -120), 50, 1},
          {at(-190, 1480, -120), at(40, 1740, -130), 45, 1},
          {at(20, 1390, 60), at(-160, 1560, -60), 45, 1},
          {at(-160, 1560, -60), at(-40, 1790, -140), 40, 1}};
}

TEST(SegmentFurniture, WhoHidesTheHeadIsFoundByTheRoundBody) {
  for (const float x : {-250.0F, 0.0F, 250.0F}) {
    const Shares s = first_frame(room_with(hidden_head_at(x, 2500)));
    EXPECT_TRUE(s.found) << x;
    EXPECT_GT(s.overlap, 0.9) << x;
  }
}

// Chests, coats and hats where a person would be: of a person's size, with a head of a kind, but flat.
TEST(SegmentFurniture, WhatIsFlatIsNoPerson) {
  const std::vector<Box> chair = chair_at(0, 2700);
  std::vector<Box> coat = chair;
  coat.push_back({{-230, 60, 2830}, {230, 1180, 2960}});
  const Capsule hat = {{0, 1270, 2890}, {0, 1271, 2890}, 105, 9};
  const std::vector<std::pair<std::string, Scene>> scenes = {
      {"coat and hat on a chair", room_with({hat}, coat)},
      {"stand against the upper border",
       room_with({{{0, 1990, 2300}, {0, 1991, 2300}, 110, 9}}, {{{-200, 1000, 2250}, {200, 1880, 2380}},
                                                                {{-220, 0, 2200}, {220, 600, 2500}},
                                                                {{-25, 600, 2300}, {25, 1000, 2350}}})},
      {"cartons", room_with({}, {{{-250, 0, 2500}, {250, 420, 2900}},
                                 {{-210, 420, 2520}, {260, 800, 2880}},
                                 {{-240, 800, 2500}, {200, 1180, 2850}},
                                 {{-100, 1180, 2560}, {90, 1400, 2750}}})}};
  for (const auto& [name, scene] : scenes)
    for (std::uint64_t seed = 1; seed <= 4; ++seed) EXPECT_FALSE(first_frame(scene, seed).found) << name << seed;
}

}  // namespace
}  // namespace im2fit
