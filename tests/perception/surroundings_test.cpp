// SPDX-License-Identifier: Apache-2.0
// Floors that are flat and bent, grounds at the floor and above it, heads with and without a crown: rooms in closed
// form, with their true mask and floor.
#include "perception/observe/surroundings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/observe/floor_bend.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::Scene;

Scene standing_room(float ground_mm = 0) {
  Scene s;
  s.camera_height = 1050;
  s.pitch_deg = 4;
  s.wall_z = 3400;
  std::vector<room_test::Capsule> person = room_test::person_at(0, 2400);
  for (room_test::Capsule& c : person) {
    c.a.y += ground_mm;
    c.b.y += ground_mm;
  }
  room_test::add(s, person);
  if (ground_mm > 0) s.boxes.push_back({{-260, 0, 2050}, {260, ground_mm, 2650}});
  return s;
}

struct Shown {
  Intrinsics k;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
  Person person;

  explicit Shown(const Scene& s, double noise_raw = room_test::kKinectNoise) : k(s.intrinsics()), person{} {
    room_test::Picture picture = room_test::render(s, noise_raw, 3);
    depth = std::move(picture.depth);
    mask.resize(depth.size());
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = picture.owner[i] == 1 ? 255 : 0;
    person.floor = {true, s.up_in_camera(), s.camera_height};
    box();
  }
  void box() {
    person.u_min = k.width;
    person.v_min = k.height;
    person.u_max = person.v_max = -1;
    for (int v = 0; v < k.height; ++v)
      for (int u = 0; u < k.width; ++u) {
        if (mask[at(u, v)] == 0) continue;
        person.u_min = std::min(person.u_min, u);
        person.u_max = std::max(person.u_max, u);
        person.v_min = std::min(person.v_min, v);
        person.v_max = std::max(person.v_max, v);
      }
  }
  std::size_t at(int u, int v) const { return static_cast<std::size_t>(v * k.width + u); }
  float ray_x(int u) const { return (static_cast<float>(u) - k.cx) / k.fx; }
  float ray_y(int v) const { return (static_cast<float>(v) - k.cy) / k.fy; }
  DepthView view() const { return {depth.data(), k.width, k.height}; }
  MaskView masked() const { return {mask.data(), k.width, k.height}; }
  SurroundingsSigns signs() const {
    Surroundings surroundings(k.width, k.height);
    for (int i = 0; i < 3; ++i) surroundings.add(view(), masked(), k, person);
    return surroundings.signs();
  }
  // All that stands higher loses its depth, as hair before a time-of-flight camera.
  void lose_above(float height_mm) {
    for (int v = 0; v < k.height; ++v)
      for (int u = 0; u < k.width; ++u) {
        if (mask[at(u, v)] == 0) continue;
        const float z = static_cast<float>(depth[at(u, v)]);
        const Vec3f p = {ray_x(u) * z, ray_y(v) * z, z};
        if (dot(person.floor.up, p) + person.floor.camera_height_mm < height_mm) continue;
        depth[at(u, v)] = 0;
        mask[at(u, v)] = 0;
      }
    box();
  }
  float flatness() const {
    std::vector<std::uint16_t> q4(depth.size());
    for (std::size_t i = 0; i < depth.size(); ++i) q4[i] = static_cast<std::uint16_t>(16 * depth[i]);
    JointSet joints;
    joints[Joint::HE] = {0, person.floor.camera_height_mm - 1640, 2400};
    joints[Joint::TO] = {0, person.floor.camera_height_mm - 1150, 2400};
    return crown_flatness({q4.data(), k.width, k.height}, masked(), k, joints, person.floor);
  }
};

TEST(FloorBend, OfDepthAlongTheAxisIsNone) {
  const SurroundingsSigns signs = Shown(standing_room()).signs();
  ASSERT_TRUE(signs.floor.known);
  EXPECT_NEAR(signs.floor.bend, 0, 0.01F);
}

TEST(FloorBend, OfDistancesFromTheCameraIsThatOfTheirRays) {
  Shown shown(standing_room());
  for (int v = 0; v < shown.k.height; ++v)
    for (int u = 0; u < shown.k.width; ++u) {
      const float x = shown.ray_x(u), y = shown.ray_y(v);
      std::uint16_t& depth = shown.depth[shown.at(u, v)];
      depth = static_cast<std::uint16_t>(std::lround(static_cast<float>(depth) * std::sqrt(1 + x * x + y * y)));
    }
  ASSERT_TRUE(shown.signs().floor.known);
  EXPECT_NEAR(shown.signs().floor.bend, 0.44F, 0.03F);
}

// The ray that the lens bends to a pixel: where the undistorted picture has what the pixel shows.
TEST(FloorBend, OfALensThatIsNotUndoneIsItsFirstTerm) {
  for (const float k1 : {-0.12F, 0.12F}) {
    const Shown straight(standing_room());
    Shown bent = straight;
    for (int v = 0; v < bent.k.height; ++v)
      for (int u = 0; u < bent.k.width; ++u) {
        float x = bent.ray_x(u), y = bent.ray_y(v);
        for (int i = 0; i < 20; ++i) {
          const float q = 1 + k1 * (x * x + y * y);
          x = bent.ray_x(u) / q;
          y = bent.ray_y(v) / q;
        }
        const int from_u = static_cast<int>(std::lround(x * bent.k.fx + bent.k.cx));
        const int from_v = static_cast<int>(std::lround(y * bent.k.fy + bent.k.cy));
        const bool inside = from_u >= 0 && from_u < bent.k.width && from_v >= 0 && from_v < bent.k.height;
        bent.depth[bent.at(u, v)] = inside ? straight.depth[bent.at(from_u, from_v)] : std::uint16_t{0};
        bent.mask[bent.at(u, v)] = inside ? straight.mask[bent.at(from_u, from_v)] : std::uint8_t{0};
      }
    bent.box();
    ASSERT_TRUE(bent.signs().floor.known);
    EXPECT_NEAR(bent.signs().floor.bend, k1, 0.05F);
    EXPECT_GT(std::fabs(bent.signs().floor.bend), 0.06F);
  }
}

// Between walls little is seen of the floor: three times a Kinect's noise must not pass for a bowl
// (estimate/plausibility.cpp refuses from 0.05 on).
TEST(FloorBend, BetweenTheWallsOfACabinIsNoneForAllItsNoise) {
  for (const float half : {500.0F, 400.0F, 300.0F}) {
    Scene s = standing_room();
    s.wall_z = 2900;
    s.boxes = {{{-half - 100, 0, 300}, {-half, 2800, 3000}}, {{half, 0, 300}, {half + 100, 2800, 3000}}};
    const SurroundingsSigns signs = Shown(s, 3 * room_test::kKinectNoise).signs();
    ASSERT_TRUE(signs.floor.known) << half;
    EXPECT_NEAR(signs.floor.bend, 0, 0.05F) << half;
  }
}

TEST(FloorBend, OfTooLittleFloorIsNotKnown) {
  Scene s = standing_room();
  s.floor = false;
  EXPECT_FALSE(Shown(s).signs().floor.known);
}

TEST(Ground, UnderFeetOnTheFloorIsTheFloor) {
  const SurroundingsSigns signs = Shown(standing_room()).signs();
  ASSERT_TRUE(signs.ground_known);
  EXPECT_NEAR(signs.ground_mm, 0, 3);
  EXPECT_FLOAT_EQ(signs.ground_share, signs.floor_share);
}

TEST(Ground, UnderFeetOnAPlatformIsThePlatform) {
  for (const float height : {25.0F, 40.0F, 90.0F, 180.0F}) {
    const SurroundingsSigns signs = Shown(standing_room(height)).signs();
    ASSERT_TRUE(signs.ground_known) << height;
    EXPECT_NEAR(signs.ground_mm, height, 4);
    EXPECT_GT(signs.ground_share, 0.35F);
    EXPECT_LT(signs.floor_share, signs.ground_share);
  }
}

// A mask that goes down the platform's front has its lowest points 350 mm ahead of the feet.
TEST(Ground, OfAPlatformWhoseFrontIsTakenForFeetIsThePlatform) {
  constexpr float kHeight = 180;
  Shown shown(standing_room(kHeight));
  for (int v = 0; v < shown.k.height; ++v)
    for (int u = 0; u < shown.k.width; ++u) {
      const float z = static_cast<float>(shown.depth[shown.at(u, v)]);
      const Vec3f p = {shown.ray_x(u) * z, shown.ray_y(v) * z, z};
      const float height = dot(shown.person.floor.up, p) + shown.person.floor.camera_height_mm;
      if (z > 0 && z < 2250 && height > 10 && height < kHeight - 10) shown.mask[shown.at(u, v)] = 255;
    }
  shown.box();
  const SurroundingsSigns signs = shown.signs();
  ASSERT_TRUE(signs.ground_known);
  EXPECT_NEAR(signs.ground_mm, kHeight, 4);
  EXPECT_GT(signs.ground_share, 0.6F);
  EXPECT_LT(signs.floor_share, 0.2F);
  EXPECT_FALSE(signs.feet_known) << "no toes are seen there";
}

TEST(Crown, ThatIsSeenIsADome) {
  const Shown shown(standing_room());
  EXPECT_LT(shown.flatness(), 0.8F);
  EXPECT_LT(shown.signs().lost_above_share, 0.1F);
  ASSERT_TRUE(shown.signs().above_known);
}

TEST(Crown, WithoutDepthIsFlatUnderLostPixels) {
  Shown shown(standing_room());
  const float whole = shown.flatness();
  shown.lose_above(1640);
  EXPECT_GT(shown.flatness(), whole + 0.15F);
  EXPECT_GT(shown.signs().lost_above_share, 0.6F);
  EXPECT_LT(shown.signs().lost_beside_share, 0.1F);
}

TEST(Crown, OfNoHeadIsNoNumber) {
  Shown shown(standing_room());
  std::fill(shown.mask.begin(), shown.mask.end(), std::uint8_t{0});
  EXPECT_TRUE(std::isnan(shown.flatness()));
}

}  // namespace
}  // namespace im2fit
