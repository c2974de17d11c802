// SPDX-License-Identifier: Apache-2.0
// Several people, paths, seats, empty rooms: SceneOptions beyond the one person who stands still.
#include <algorithm>
#include <cmath>
#include <vector>

#include "body_fixture.h"
#include "mesh_checks.h"
#include "train/camera/virtual_camera.h"

namespace im2fit::lab {
namespace {

constexpr int kWidth = 320, kHeight = 240;

class People : public WithBody {
 protected:
  struct Shot {
    std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kWidth * kHeight);
    std::vector<std::vector<std::uint8_t>> masks;
  };
  static Shot take(VirtualScene& scene, std::uint64_t index) {
    Shot shot;
    scene.render(index, DepthImage(shot.depth.data(), kWidth, kHeight));
    for (std::size_t who = 0; who < scene.people_count(); ++who) {
      shot.masks.emplace_back(shot.depth.size());
      scene.person_mask(MaskImage(shot.masks.back().data(), kWidth, kHeight), who);
    }
    return shot;
  }
  static VirtualScene make(const SceneOptions& options, const SensorOptions& sensor, std::uint64_t seed) {
    return {model(),
            draw_subject(model(), Family::training, 40, seed),
            options,
            sensor,
            kinect_intrinsics(kWidth, kHeight),
            seed};
  }
  static Bystander bystander(float x, float z, std::uint64_t index) {
    Bystander b;
    b.subject_seed = 8;
    b.subject_index = index;
    b.clothing = Clothing::normal;
    b.hair = true;
    b.path.from_x_mm = x;
    b.path.from_z_mm = z;
    return b;
  }
  static SceneOptions landscape() {
    SceneOptions options;
    options.rotate_deg = 0;
    options.sway = false;
    return options;
  }
  static int count(const std::vector<std::uint8_t>& mask) {
    return static_cast<int>(std::count(mask.begin(), mask.end(), std::uint8_t{255}));
  }
};

// The near one hides part of the far one. A ray through each pixel's centre meets that person's mesh first, at the
// depth delivered: half a millimetre of rounding, the raster's 1/256 px at grazing triangles.
TEST_F(People, MasksAreDisjointAndEachPixelIsOnItsPerson) {
  SceneOptions options = landscape();
  options.clothing = Clothing::loose;
  options.others = {bystander(350, -600, 1), bystander(-700, 100, 2)};
  VirtualScene scene = make(options, exact_sensor(), 3);
  ASSERT_EQ(scene.people_count(), 3U);
  const Shot shot = take(scene, 0);
  std::vector<VirtualScene::Surface> meshes;
  for (std::size_t who = 0; who < 3; ++who) meshes.push_back(scene.person_surface(0, who));
  const Intrinsics k = scene.intrinsics();
  int checked = 0;
  for (std::size_t i = 0; i < shot.depth.size(); ++i) {
    int owners = 0;
    for (const auto& mask : shot.masks) owners += mask[i] == 255 ? 1 : 0;
    ASSERT_LE(owners, 1);
    if (owners == 0 || i % 61 != 0) continue;
    const std::size_t column = i % kWidth, row = i / kWidth;
    const auto u = static_cast<float>(column), v = static_cast<float>(row);
    const Vec3f ray{(u - k.cx) / k.fx, (v - k.cy) / k.fy, 1};
    float nearest = 1e9F;
    std::size_t first = 9;
    for (std::size_t who = 0; who < 3; ++who) {
      const float z = first_hit({}, ray, meshes[who].vertices, meshes[who].triangles);
      if (z > 0 && z < nearest) {
        nearest = z;
        first = who;
      }
    }
    if (first == 9) continue;  // an outline's pixel, within 1/256 px of missing
    ++checked;
    EXPECT_EQ(shot.masks[first][i], 255) << "pixel " << u << "," << v;
    EXPECT_NEAR(shot.depth[i], nearest, 4) << "pixel " << u << "," << v;
  }
  EXPECT_GT(checked, 100);
  for (const auto& mask : shot.masks) EXPECT_GT(count(mask), 1000);
}

TEST_F(People, CompanyLeavesTheMainPersonAlone) {
  SceneOptions options = landscape();
  VirtualScene alone = make(options, exact_sensor(), 4);
  options.others = {bystander(900, -800, 5)};
  VirtualScene together = make(options, exact_sensor(), 4);
  EXPECT_EQ(take(alone, 0).masks[0], take(together, 0).masks[0]);
  EXPECT_EQ(alone.distance_mm(), together.distance_mm());
  EXPECT_EQ(alone.joints(0)[Joint::HE].x, together.joints(0)[Joint::HE].x);
  EXPECT_NE(together.joints(0, 1)[Joint::HE].x, together.joints(0)[Joint::HE].x);
  EXPECT_EQ(together.joints(0, 2).confidence[0], 0);
}

// Walls are moved back: in a walled room everybody far behind and aside is seen as in one without walls.
TEST_F(People, NoPersonStandsInAWall) {
  for (std::uint64_t i = 0; i < 8; ++i) {
    SceneOptions options = landscape();
    options.distance_mm = 3000;
    options.camera_height_mm = 1000;
    options.others = {bystander(i % 2 == 0 ? 1300 : -1300, -1800, 1)};
    VirtualScene walled = make(options, exact_sensor(), i);
    options.wall = false;
    VirtualScene open = make(options, exact_sensor(), i);
    EXPECT_EQ(take(walled, 0).masks[1], take(open, 0).masks[1]) << i;
  }
}

// Hips follow the path at 30 frames a second, feet stay on the floor, the walker looks where it leads.
TEST_F(People, WalksAlongItsPath) {
  SceneOptions options = landscape();
  options.walk = {-600, -300, 600, 300, 10, 30};
  options.clothing = Clothing::normal;
  options.camera_height_mm = 1000;
  options.distance_mm = 3500;
  options.pitch_deg = 0;
  VirtualScene scene = make(options, kinect_sensor(), 6);
  const FloorPlane floor = scene.floor();
  const JointSet start = scene.joints(0), end = scene.joints(60);
  const auto hips = [](const JointSet& j) { return (j[Joint::LH] + j[Joint::RH]) * 0.5F; };
  const Vec3f path = hips(end) - hips(start);
  EXPECT_NEAR(norm(path), std::hypot(1200, 600), 40);
  EXPECT_LT(path.z, -500);  // towards the camera
  EXPECT_GT(path.x, 1100);
  float stride = 0;
  for (std::uint64_t frame = 0; frame <= 50; frame += 5) {
    const float t = std::clamp((static_cast<float>(frame) - 10) / 30, 0.0F, 1.0F);
    const JointSet j = scene.joints(frame);
    const Vec3f expected = hips(start) + path * t;
    EXPECT_NEAR(hips(j).x, expected.x, 30) << frame;
    EXPECT_NEAR(hips(j).z, expected.z, 30) << frame;
    stride = std::max(stride, norm(j[Joint::LF] - j[Joint::RF]));
    float lowest = 1e9F;
    for (const Vec3f& p : scene.person_surface(frame).vertices)
      lowest = std::min(lowest, dot(floor.up, p) + floor.camera_height_mm);
    EXPECT_NEAR(lowest, 0, 0.5) << frame;
  }
  EXPECT_GT(stride, 450);
  // Halfway the left hip lies to the left of the path: the person's left is its right hand side turned about.
  const JointSet half = scene.joints(25);
  const Vec3f across = normalized(half[Joint::LH] - half[Joint::RH]), ahead = normalized({path.x, 0, path.z});
  EXPECT_LT(std::fabs(dot(across, ahead)), 0.35F);
  EXPECT_GT(dot(cross(ahead, across), floor.up), 0.8F);
}

// Half a turn about the upright line through the hips: r becomes 2 (u.r) u - r.
TEST_F(People, TurnsRoundOnTheSpot) {
  SceneOptions options = landscape();
  options.yaw_deg = 0;
  options.turn = {10, 40};
  options.camera_height_mm = 1000;
  options.distance_mm = 3000;
  VirtualScene scene = make(options, exact_sensor(), 6);
  const FloorPlane floor = scene.floor();
  const JointSet facing = scene.joints(0);
  const Vec3f middle = (facing[Joint::LH] + facing[Joint::RH]) * 0.5F;
  for (const std::uint64_t frame : {10U, 50U, 500U}) {
    const JointSet found = scene.joints(frame);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const Vec3f r = facing.position_mm[j] - middle;
      const Vec3f expected = frame == 10 ? r : floor.up * (2 * dot(floor.up, r)) - r;
      EXPECT_LT(norm(found.position_mm[j] - middle - expected), 0.1F) << kJointNames[j] << " in " << frame;
    }
  }
  const JointSet half = scene.joints(30);
  const Vec3f ahead = cross(normalized(half[Joint::LH] - half[Joint::RH]), floor.up);
  EXPECT_LT(ahead.x, -0.9F) << "towards the person's right, the picture's left";
  for (std::uint64_t frame = 0; frame <= 60; frame += 5) {
    float lowest = 1e9F;
    for (const Vec3f& p : scene.person_surface(frame).vertices)
      lowest = std::min(lowest, dot(floor.up, p) + floor.camera_height_mm);
    EXPECT_NEAR(lowest, 0, 0.5) << frame;
  }
  EXPECT_NE(take(scene, 0).masks, take(scene, 30).masks);
}

TEST_F(People, FramesOfAWalkDoNotDependOnTheOrder) {
  SceneOptions options = landscape();
  options.walk = {-500, 0, 500, 0, 0, 40};
  options.others = {bystander(400, -700, 3)};
  options.others[0].path = {700, -700, -700, -700, 5, 30};
  options.furniture_count = 2;
  VirtualScene a = make(options, kinect_sensor(), 7), b = make(options, kinect_sensor(), 7);
  const Shot straight = take(a, 20);
  (void)take(b, 33);
  (void)take(b, 0);
  (void)b.joints(12, 1);
  const Shot around = take(b, 20);
  EXPECT_EQ(straight.depth, around.depth);
  EXPECT_EQ(straight.masks, around.masks);
}

TEST_F(People, RestagedIsAsNewWithEverythingOn) {
  SceneOptions first = landscape(), second = landscape();
  first.clothing = Clothing::loose;
  first.hair = true;
  first.others = {bystander(700, -300, 1), bystander(-800, -300, 2)};
  first.pose = StandingPose::seated;
  second.pose = StandingPose::crossed;
  second.clothing = Clothing::normal;
  second.others = {bystander(800, 0, 2)};
  second.furniture_touching = true;
  second.decoy_count = 1;
  for (const bool dressed : {true, false}) {
    if (!dressed) second.clothing = Clothing::none;
    VirtualScene used = make(first, tof_sensor(), 1);
    (void)take(used, 3);
    used.restage(draw_subject(model(), Family::training, 40, 2), second, 2);
    VirtualScene fresh = make(second, tof_sensor(), 2);
    const Shot a = take(used, 0), b = take(fresh, 0);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.masks, b.masks);
  }
}

// What one person wears is made once for front and back, and anew for another person or in something else.
TEST_F(People, RestagedInTheSameClothesIsAsNew) {
  std::vector<Vec3f> rest, others_rest;
  const Subject one = draw_subject(model(), Family::training, 40, 2, rest);
  const Subject other = draw_subject(model(), Family::training, 40, 3, others_rest);
  SceneOptions front = landscape();
  front.clothing = Clothing::loose;
  front.hair = true;
  front.outfit_seed = 77;
  SceneOptions back = front, naked = front, bare_headed = front;
  back.back_view = true;
  naked.clothing = Clothing::none;
  naked.hair = false;
  bare_headed.hair = false;
  VirtualScene used = make(front, kinect_sensor(), 1);
  std::uint64_t seed = 1;
  for (const SceneOptions& options : {front, back, naked, back, bare_headed, front})
    for (const bool of_one : {true, false}) {
      const Subject& subject = of_one ? one : other;
      used.restage(subject, options, kinect_sensor(), ++seed, of_one ? rest : others_rest);
      VirtualScene fresh(model(), subject, options, kinect_sensor(), used.intrinsics(), seed);
      for (int again = 0; again < 2; ++again) {
        const Shot a = take(used, 0), b = take(fresh, 0);
        ASSERT_EQ(a.depth, b.depth);
        ASSERT_EQ(a.masks, b.masks);
        used.restage(subject, options, kinect_sensor(), seed, of_one ? rest : others_rest);
      }
    }
}

// The camera sees a plate that hangs before the body, in the body's own axes. The plate is the person's.
TEST_F(People, GarmentsHangOnThePosedBody) {
  constexpr float kBeforeMm = 400;
  SceneOptions options = landscape();
  options.yaw_deg = 0;
  options.clothing = Clothing::garments;
  VirtualScene bare = make(options, exact_sensor(), 4);
  int calls = 0;
  options.dresser = [&](std::span<const Vec3f> rest, const body::Skeleton& skeleton, const body::Pose& pose) {
    ++calls;
    EXPECT_EQ(rest.size(), static_cast<std::size_t>(model().vertex_count()));
    const Vec3f middle = body::pose_skeleton(skeleton, pose).head[0] + Vec3f{0, 0, kBeforeMm};
    DrapedCloth cloth;
    for (const float x : {-150.0F, 150.0F})
      for (const float y : {-150.0F, 150.0F}) cloth.vertices.push_back(middle + Vec3f{x, y, 0});
    cloth.triangles = {{0, 1, 2}, {1, 3, 2}};
    return cloth;
  };
  VirtualScene dressed = make(options, exact_sensor(), 4);
  const Shot a = take(bare, 0), b = take(dressed, 0);
  EXPECT_EQ(calls, 1);
  int nearer = 0;
  for (std::size_t i = 0; i < a.depth.size(); ++i) {
    if (b.masks[0][i] != 255 || b.depth[i] == 0 || a.depth[i] < b.depth[i] + kBeforeMm / 2) continue;
    ++nearer;
  }
  // 300 mm square, 2.4 to 3.2 m and more away, of 288 pixels focal length: 27 to 36 pixels a side.
  EXPECT_GT(nearer, 500);
  EXPECT_LT(nearer, 1600);
}

TEST_F(People, AnEmptyRoomHasNoPersonInIt) {
  SceneOptions options = landscape();
  options.person = false;
  options.furniture_count = 3;
  options.decoy_count = 2;
  VirtualScene scene = make(options, exact_sensor(), 9);
  const Shot shot = take(scene, 0);
  EXPECT_EQ(count(shot.masks[0]), 0);
  EXPECT_TRUE(scene.person_box().empty());
  for (const float c : scene.joints(0).confidence) EXPECT_EQ(c, 0);
  EXPECT_GT(std::count_if(shot.depth.begin(), shot.depth.end(), [](std::uint16_t z) { return z > 0; }), 20000);
}

// Under the seat there is a chair: between floor and thighs the picture shows furniture, and the person's lowest
// point is still the feet.
TEST_F(People, SeatedPeopleSitOnSomething) {
  for (std::uint64_t i = 0; i < 6; ++i) {
    SceneOptions options = landscape();
    options.pose = StandingPose::seated;
    options.clothing = i % 2 == 0 ? Clothing::none : Clothing::normal;
    options.yaw_deg = 90;  // from the side: thighs and seat in profile
    options.wall = false;
    VirtualScene scene = make(options, exact_sensor(), i);
    const Shot shot = take(scene, 0);
    const FloorPlane floor = scene.floor();
    const JointSet j = scene.joints(0);
    const Intrinsics k = scene.intrinsics();
    const float hip_height = dot(floor.up, j[Joint::LH]) + floor.camera_height_mm;
    EXPECT_GT(hip_height, 380);
    EXPECT_LT(hip_height, 680);
    int chair = 0;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const std::size_t at = static_cast<std::size_t>(v) * kWidth + static_cast<std::size_t>(u);
        if (shot.depth[at] == 0 || shot.masks[0][at] != 0) continue;
        const Vec3f p = unproject(k, static_cast<float>(u), static_cast<float>(v), shot.depth[at]);
        const float height = dot(floor.up, p) + floor.camera_height_mm;
        const Vec3f off = p - j[Joint::LH];
        chair += height > 30 && height < hip_height && std::hypot(off.x, off.z) < 600 ? 1 : 0;
      }
    }
    EXPECT_GT(chair, 60) << i;
  }
}

// Touching furniture is drawn, beside or behind the legs and never before them: the person's mask stays.
TEST_F(People, TouchingFurnitureHidesNothingAndIsNear) {
  int near = 0;
  for (std::uint64_t i = 0; i < 10; ++i) {
    SceneOptions options = landscape();
    options.wall = false;
    VirtualScene plain = make(options, exact_sensor(), i);
    options.furniture_touching = true;
    VirtualScene touched = make(options, exact_sensor(), i);
    const Shot a = take(plain, 0), b = take(touched, 0);
    const int lost = count(a.masks[0]) - count(b.masks[0]);
    EXPECT_LE(lost, count(a.masks[0]) / 25) << i;  // a low piece's front corner may reach over a foot's edge
    const FloorPlane floor = touched.floor();
    const JointSet j = touched.joints(0);
    bool close = false;
    for (std::size_t p = 0; p < b.depth.size() && !close; ++p) {
      if (b.masks[0][p] != 0 || b.depth[p] == 0 || b.depth[p] == a.depth[p]) continue;
      const std::size_t column = p % kWidth, row = p / kWidth;
      const Vec3f at =
          unproject(touched.intrinsics(), static_cast<float>(column), static_cast<float>(row), b.depth[p]);
      if (dot(floor.up, at) + floor.camera_height_mm > 500) continue;
      for (const Joint foot : {Joint::LF, Joint::RF}) close = close || norm(at - j[foot]) < 260;
    }
    near += close ? 1 : 0;
  }
  EXPECT_GE(near, 8);
}

}  // namespace
}  // namespace im2fit::lab
