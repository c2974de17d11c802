// SPDX-License-Identifier: Apache-2.0
// Head over legs, on people whose bend is known: turned by hand about the hips.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "perception/observe/gate.h"
#include "perception/observe/lean.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::Capsule;
using room_test::Scene;

constexpr float kZ = 2800;
constexpr float kHipsMm = 930;

Scene room(float pitch_deg = 4) {
  Scene s;
  s.width = 240;
  s.height = 320;
  s.focal = 287.9F;
  s.camera_height = 1050;
  s.pitch_deg = pitch_deg;
  return s;
}

// The figure with all above the hips turned by `degrees`, towards the camera (`aside` 0) or aside (1).
std::vector<Capsule> bent(float degrees, float aside) {
  const float a = degrees * std::numbers::pi_v<float> / 180;
  const float s = std::sin(a), c = std::cos(a);
  const auto turn = [&](Vec3f p) {
    const float up = p.y - kHipsMm, away = p.z - kZ;
    if (up <= 0) return p;
    if (aside > 0) return Vec3f{c * p.x + s * up, kHipsMm + c * up - s * p.x, p.z};
    return Vec3f{p.x, kHipsMm + c * up + s * away, kZ + c * away - s * up};
  };
  std::vector<Capsule> out = room_test::person_at(0, kZ);
  for (Capsule& capsule : out) {
    capsule.a = turn(capsule.a);
    capsule.b = turn(capsule.b);
  }
  return out;
}

// The true mask and floor: nothing of the segmenter.
struct Observed {
  room_test::Picture picture;
  std::vector<std::uint8_t> mask;
  Person person;
};
Observed observe(const Scene& s) {
  Observed l;
  l.picture = room_test::render(s, 0.5, 7);
  l.mask.resize(l.picture.depth.size());
  Person& p = l.person;
  p.floor = {true, s.up_in_camera(), s.camera_height};
  p.u_min = s.width;
  p.v_min = s.height;
  Vec3f sum;
  for (int v = 0; v < s.height; ++v)
    for (int u = 0; u < s.width; ++u) {
      const auto i = static_cast<std::size_t>(v * s.width + u);
      if (l.picture.owner[i] != 1) continue;
      l.mask[i] = 255;
      ++p.pixel_count;
      p.u_min = std::min(p.u_min, u);
      p.u_max = std::max(p.u_max, u);
      p.v_min = std::min(p.v_min, v);
      p.v_max = std::max(p.v_max, v);
      sum = sum + unproject(s.intrinsics(), static_cast<float>(u), static_cast<float>(v),
                            static_cast<float>(l.picture.depth[i]));
    }
  p.found = true;
  p.centroid_mm = sum * (1.0F / static_cast<float>(p.pixel_count));
  return l;
}
Lean lean_in(const Scene& s, const Observed& l, const User* head = nullptr) {
  return lean_of(l.picture.view(), {l.mask.data(), s.width, s.height}, s.intrinsics(), l.person, head);
}
Lean lean_in(const Scene& s, const User* head = nullptr) {
  return lean_in(s, observe(s), head);
}
bool not_upright(const Lean& lean) {
  return has(pose_gate(JointSet{}, {true, {0, -1, 0}, 1000}, ViewSide::front, lean), Guidance::not_upright);
}

TEST(Lean, WhoStandsUprightHasHardlyAnyHoweverTheCameraIsTilted) {
  for (const float pitch : {-6.0F, 4.0F, 14.0F}) {
    Scene s = room(pitch);
    room_test::add(s, room_test::person_at(0, kZ));
    const Lean lean = lean_in(s);
    ASSERT_TRUE(lean.seen) << pitch;
    EXPECT_LT(lean.tangent, 0.1F) << pitch;
    EXPECT_FALSE(not_upright(lean));
  }
}

// The head's middle is 1640 mm up, 710 above the hips; the legs' middle about 420: the head moves by 710 sin b and
// stands 510 + 710 cos b above the legs.
TEST(Lean, FollowsTheBend) {
  for (const float degrees : {20.0F, 30.0F, 40.0F})
    for (const float aside : {0.0F, 1.0F}) {
      Scene s = room();
      room_test::add(s, bent(degrees, aside));
      const Lean lean = lean_in(s);
      ASSERT_TRUE(lean.seen);
      const float b = degrees * std::numbers::pi_v<float> / 180;
      EXPECT_NEAR(lean.tangent, 710 * std::sin(b) / (510 + 710 * std::cos(b)), 0.09F) << degrees << ' ' << aside;
    }
}

TEST(Lean, SaysNotUprightFromAboutTwentyDegreesOn) {
  for (const float aside : {0.0F, 1.0F}) {
    for (const float degrees : {4.0F, 8.0F}) {
      Scene s = room();
      room_test::add(s, bent(degrees, aside));
      EXPECT_FALSE(not_upright(lean_in(s))) << degrees << ' ' << aside;
    }
    for (const float degrees : {25.0F, 45.0F}) {
      Scene s = room();
      room_test::add(s, bent(degrees, aside));
      EXPECT_TRUE(not_upright(lean_in(s))) << degrees << ' ' << aside;
    }
  }
}

TEST(Lean, ARaisedHandIsNoHead) {
  Scene s = room();
  std::vector<Capsule> person = room_test::person_at(0, kZ);
  person.push_back({{170, 1390, kZ}, {420, 1950, kZ}, 45, 1});
  room_test::add(s, person);
  User user;
  user.has_head = true;
  user.head_mm = s.to_camera({0, 1750, kZ - 60});
  const Lean lean = lean_in(s, &user);
  ASSERT_TRUE(lean.seen);
  EXPECT_LT(lean.tangent, 0.1F);
}

TEST(Lean, NeedsFloorHeadAndLegs) {
  Scene s = room();
  room_test::add(s, room_test::person_at(0, kZ));
  Observed l = observe(s);
  ASSERT_TRUE(lean_in(s, l).seen);
  for (int v = 0; v < s.height; ++v)  // a table before the legs
    for (int u = 0; u < s.width; ++u) {
      const auto i = static_cast<std::size_t>(v * s.width + u);
      const Vec3f p = unproject(s.intrinsics(), static_cast<float>(u), static_cast<float>(v),
                                static_cast<float>(l.picture.depth[i]));
      if (dot(s.up_in_camera(), p) + s.camera_height < 750) l.mask[i] = 0;
    }
  EXPECT_FALSE(lean_in(s, l).seen);
  Observed unknown = observe(s);
  unknown.person.floor.known = false;
  EXPECT_FALSE(lean_in(s, unknown).seen);
}

}  // namespace
}  // namespace im2fit
