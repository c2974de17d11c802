// SPDX-License-Identifier: Apache-2.0
#include "train/camera/virtual_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "body_fixture.h"
#include "hal/source.h"

namespace im2fit::lab {
namespace {

TEST(Mounting, KinectIntrinsics) {
  const Intrinsics full = kinect_intrinsics(640, 480);
  EXPECT_FLOAT_EQ(full.fx, 575.8F);
  EXPECT_FLOAT_EQ(full.cx, 319.5F);
  EXPECT_FLOAT_EQ(full.cy, 239.5F);
  const Intrinsics half = kinect_intrinsics(320, 240);
  EXPECT_FLOAT_EQ(half.fy, 287.9F);
  EXPECT_FLOAT_EQ(half.cx, 159.5F);
  EXPECT_FLOAT_EQ(half.cy, 119.5F);
}

// The header's table of upright(u', v') = in(u, v).
std::array<int, 2> sensor_pixel(int rotate_deg, int u, int v, int width, int height) {
  switch (rotate_deg) {
    case 90:
      return {v, height - 1 - u};
    case 180:
      return {width - 1 - u, height - 1 - v};
    case 270:
      return {width - 1 - v, u};
    default:
      return {u, v};
  }
}

// A point seen at an upright pixel is the same point seen at the sensor's pixel of that table.
TEST(Mounting, AxesAndPixelsAgree) {
  Intrinsics sensor = kinect_intrinsics(640, 480);
  sensor.cx = 310;  // off centre, and unequal focal lengths, so that a mix-up shows
  sensor.cy = 250;
  sensor.fy = 570;
  for (const int rotate : {0, 90, 180, 270}) {
    const Intrinsics upright = hal::rotate_upright(sensor, rotate);
    EXPECT_EQ(upright.width, rotate % 180 == 0 ? 640 : 480);
    for (const auto& [u, v] : {std::pair{10, 20}, {300, 400}, {77, 311}}) {
      const Vec3f p = unproject(upright, static_cast<float>(u), static_cast<float>(v), 2000);
      const auto [su, sv] = sensor_pixel(rotate, u, v, 640, 480);
      const Vec3f q = upright_to_sensor(p, rotate);
      EXPECT_NEAR(q.x * sensor.fx / q.z + sensor.cx, su, 1e-3) << rotate;
      EXPECT_NEAR(q.y * sensor.fy / q.z + sensor.cy, sv, 1e-3) << rotate;
    }
  }
}

class VirtualCamera : public WithBody {
 protected:
  static constexpr int kWidth = 640, kHeight = 480;
  struct Shot {
    std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kWidth * kHeight);
    std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(kWidth * kHeight);
  };
  static Shot take(VirtualScene& scene, std::uint64_t index) {
    Shot shot;
    scene.render(index, DepthImage(shot.depth.data(), kWidth, kHeight));
    scene.person_mask(MaskImage(shot.mask.data(), kWidth, kHeight));
    return shot;
  }
  static VirtualScene make(const SceneOptions& options, const SensorOptions& sensor, std::uint64_t seed,
                           Family family = Family::training) {
    return {model(), draw_subject(model(), family, 40, seed), options,
            sensor,  kinect_intrinsics(kWidth, kHeight),      seed};
  }
};

TEST_F(VirtualCamera, WholePersonFitsByDefault) {
  for (std::uint64_t i = 0; i < 50; ++i) {
    SceneOptions options;
    options.rotate_deg = std::array<int, 4>{90, 0, 270, 180}[i % 4];
    options.pose = std::array<StandingPose, 4>{StandingPose::relaxed, StandingPose::relaxed, StandingPose::psi,
                                               StandingPose::free}[(i / 4) % 4];
    VirtualScene scene = make(options, kinect_sensor(), i);
    const Intrinsics k = hal::rotate_upright(scene.intrinsics(), options.rotate_deg);
    std::vector<Vec3f> mesh(static_cast<std::size_t>(model().body_vertex_count()));
    for (const std::uint64_t frame : {0, 45}) {
      scene.person_mesh(frame, mesh);
      for (const Vec3f& p : mesh) {
        const float u = p.x * k.fx / p.z + k.cx, v = p.y * k.fy / p.z + k.cy;
        ASSERT_TRUE(u > 4 && v > 4 && u < static_cast<float>(k.width) - 5 && v < static_cast<float>(k.height) - 5)
            << "subject " << i << " at " << u << "," << v;
      }
    }
    EXPECT_LE(scene.distance_mm(), 4500);
    EXPECT_GE(scene.distance_mm(), 2000);
  }
}

// Truth against the picture: each joint's pixel shows the person at about the joint's own depth, never far in
// front of it. Joints lie inside the body: the surface before them is at most a trunk's half depth nearer.
TEST_F(VirtualCamera, JointsLieInsideTheRenderedPerson) {
  for (const int rotate : {0, 90, 180, 270}) {
    for (std::uint64_t i = 0; i < 6; ++i) {
      SceneOptions options;
      options.rotate_deg = rotate;
      options.back_view = i % 3 == 2;
      options.furniture_count = 2;
      SensorOptions sensor = exact_sensor();
      VirtualScene scene = make(options, sensor, i);
      const Shot shot = take(scene, 9);
      const Intrinsics k = hal::rotate_upright(scene.intrinsics(), rotate);
      const JointSet joints = scene.joints(9);
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const Vec3f p = joints.position_mm[j];
        const int u = static_cast<int>(std::lround(p.x * k.fx / p.z + k.cx));
        const int v = static_cast<int>(std::lround(p.y * k.fy / p.z + k.cy));
        const auto [su, sv] = sensor_pixel(rotate, u, v, kWidth, kHeight);
        const std::size_t at = static_cast<std::size_t>(sv) * kWidth + static_cast<std::size_t>(su);
        // A hand's joint may lie between two fingers: the person is at the pixel or beside it.
        bool on_person = false;
        for (const int dv : {-1, 0, 1})
          for (const int du : {-1, 0, 1}) {
            const auto beside = static_cast<std::size_t>(sv + dv) * kWidth + static_cast<std::size_t>(su + du);
            on_person |= beside < shot.mask.size() && shot.mask[beside] == 255;
          }
        ASSERT_TRUE(on_person) << kJointNames[j] << " rotate " << rotate << " subject " << i;
        if (shot.mask[at] != 255) continue;
        const float before = p.z - static_cast<float>(shot.depth[at]);
        EXPECT_GT(before, -15) << kJointNames[j];
        EXPECT_LT(before, 260) << kJointNames[j];
      }
      // The person's left is the picture's right when facing the camera.
      EXPECT_EQ(joints[Joint::LS].x > joints[Joint::RS].x, !options.back_view);
      EXPECT_LT(joints[Joint::HE].y, joints[Joint::LF].y);
    }
  }
}

TEST_F(VirtualCamera, FloorTruthHoldsFeetAndFloorPixels) {
  for (const int rotate : {0, 90}) {
    SceneOptions options;
    options.rotate_deg = rotate;
    options.wall = false;
    options.sway = false;
    VirtualScene scene = make(options, exact_sensor(), 3);
    const FloorPlane floor = scene.floor();
    ASSERT_TRUE(floor.known);
    EXPECT_NEAR(norm(floor.up), 1, 1e-5);
    EXPECT_LT(floor.up.y, -0.9F);
    std::vector<Vec3f> mesh(static_cast<std::size_t>(model().body_vertex_count()));
    scene.person_mesh(0, mesh);
    float lowest = 1e9F, highest = -1e9F;
    for (const Vec3f& p : mesh) {
      lowest = std::min(lowest, dot(floor.up, p) + floor.camera_height_mm);
      highest = std::max(highest, dot(floor.up, p) + floor.camera_height_mm);
    }
    EXPECT_NEAR(lowest, 0, 0.5);
    const Subject subject = draw_subject(model(), Family::training, 40, 3);
    EXPECT_NEAR(highest, subject.truth[measurement_index(Measurement::stature)], 45);  // posture

    // Every other pixel with data is floor, to the rounding of a millimetre.
    const Shot shot = take(scene, 0);
    const Intrinsics k = hal::rotate_upright(scene.intrinsics(), rotate);
    int counted = 0;
    for (int v = 0; v < k.height; v += 3) {
      for (int u = 0; u < k.width; u += 3) {
        const auto [su, sv] = sensor_pixel(rotate, u, v, kWidth, kHeight);
        const std::size_t at = static_cast<std::size_t>(sv) * kWidth + static_cast<std::size_t>(su);
        if (shot.depth[at] == 0 || shot.depth[at] > 8000 || shot.mask[at] != 0) continue;
        const Vec3f p = unproject(k, static_cast<float>(u), static_cast<float>(v), shot.depth[at]);
        ++counted;
        ASSERT_NEAR(dot(floor.up, p) + floor.camera_height_mm, 0, 1.2);
      }
    }
    EXPECT_GT(counted, 1500);
  }
}

TEST_F(VirtualCamera, FramesDependOnSeedAndIndexOnly) {
  for (const bool sway : {true, false}) {
    SceneOptions options;
    options.furniture_count = 3;
    options.sway = sway;
    VirtualScene a = make(options, kinect_sensor(), 5), b = make(options, kinect_sensor(), 5),
                 other = make(options, kinect_sensor(), 6);
    const Shot fifth = take(a, 5);
    (void)take(b, 17);
    (void)take(b, 2);
    const Shot again = take(b, 5);
    EXPECT_EQ(again.depth, fifth.depth);
    EXPECT_EQ(again.mask, fifth.mask);
    EXPECT_NE(take(b, 6).depth, fifth.depth);
    EXPECT_NE(take(other, 5).depth, fifth.depth);
  }
}

TEST_F(VirtualCamera, RestagedIsAsNew) {
  SceneOptions first, second;
  first.furniture_count = 4;
  second.pose = StandingPose::psi;
  second.furniture_count = 1;
  for (const int margin : {-1, 12}) {
    SensorOptions sensor;
    sensor.box_margin_px = margin;
    VirtualScene used = make(first, sensor, 1);
    (void)take(used, 3);
    used.restage(draw_subject(model(), Family::training, 40, 2), second, 2);
    VirtualScene fresh = make(second, sensor, 2);
    EXPECT_EQ(take(used, 0).depth, take(fresh, 0).depth);
    const Shot a = take(used, 30), b = take(fresh, 30);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.mask, b.mask);
    for (const bool smooth : {false, true}) {
      SensorOptions other = sensor;
      other.depth_scale = 1.003F;
      other.quantise = !smooth;
      used.restage(draw_subject(model(), Family::training, 40, 2), second, other, 2);
      VirtualScene changed = make(second, other, 2);
      EXPECT_EQ(take(used, 1).depth, take(changed, 1).depth);
    }
  }
}

// Box frames hold the whole frame's pixels inside the box and nothing outside.
TEST_F(VirtualCamera, BoxFramesAreCutFromWholeFrames) {
  SceneOptions options;
  options.furniture_count = 2;
  SensorOptions boxed;
  boxed.box_margin_px = 8;
  VirtualScene whole_scene = make(options, kinect_sensor(), 4), box_scene = make(options, boxed, 4);
  for (const std::uint64_t frame : {0, 20}) {
    const Shot w = take(whole_scene, frame), b = take(box_scene, frame);
    EXPECT_EQ(w.mask, b.mask);
    int inside = 0;
    for (std::size_t i = 0; i < w.depth.size(); ++i) {
      if (b.depth[i] == 0) continue;
      ++inside;
      ASSERT_EQ(b.depth[i], w.depth[i]);
    }
    EXPECT_GT(inside, 30000);
    EXPECT_LT(inside, 200000);
  }
}

TEST_F(VirtualCamera, PartsAreCutFromWholeFrames) {
  SceneOptions options;
  options.furniture_count = 2;
  options.sway = false;
  VirtualScene scene = make(options, kinect_sensor(), 4), other = make(options, kinect_sensor(), 4);
  (void)take(scene, 0);
  const PixelBox box = scene.person_box();
  const Shot whole = take(other, 7);
  Shot part;
  part.depth.assign(whole.depth.size(), 12345);
  scene.render_part(7, box, {part.depth.data(), 640, 480});
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      const bool inside = u >= box.u0 && u < box.u1 && v >= box.v0 && v < box.v1;
      const auto at = static_cast<std::size_t>(v * 640 + u);
      ASSERT_EQ(part.depth[at], inside ? whole.depth[at] : 12345) << u << ", " << v;
    }
}

TEST_F(VirtualCamera, SwayIsSmallAndCanBeOff) {
  SceneOptions options;
  VirtualScene scene = make(options, kinect_sensor(), 7);
  float most = 0;
  const JointSet first = scene.joints(0);
  for (std::uint64_t f = 0; f < 300; f += 10) {
    const JointSet j = scene.joints(f);
    most = std::max(most, norm(j[Joint::HE] - first[Joint::HE]));
    EXPECT_LT(norm(j[Joint::LF] - first[Joint::LF]), 6);
  }
  EXPECT_GT(most, 2);
  EXPECT_LT(most, 40);
  options.sway = false;
  VirtualScene still = make(options, kinect_sensor(), 7);
  EXPECT_EQ(still.joints(0)[Joint::HE].x, still.joints(200)[Joint::HE].x);
}

// Against the same scene without noise: a flying pixel is off its surface, any other person's pixel on it.
TEST_F(VirtualCamera, MixedMaskHoldsThePersonsFlyingPixels) {
  SceneOptions options;
  options.sway = false;
  options.wall_distance_mm = 1200;
  VirtualScene exact = make(options, exact_sensor(), 5), tof = make(options, tof_sensor(), 5);
  const Shot clean = take(exact, 3), seen = take(tof, 3);
  std::vector<std::uint8_t> mixed(seen.mask.size());
  tof.mixed_mask(MaskImage(mixed.data(), kWidth, kHeight));
  constexpr int kNoiseMm = 50;  // more than five standard deviations, of grazing surfaces
  int mixed_count = 0, on_surface = 0, off_surface = 0;
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    if (seen.mask[i] == 0) {
      ASSERT_EQ(mixed[i], 0);
      continue;
    }
    ASSERT_EQ(clean.mask[i], 255);
    const int off = std::abs(int{seen.depth[i]} - int{clean.depth[i]});
    if (mixed[i] != 0) {
      ++mixed_count;
      EXPECT_GT(off, static_cast<int>(kMixedMm) - kNoiseMm);
    } else {
      (off <= static_cast<int>(kMixedMm) + kNoiseMm ? on_surface : off_surface) += 1;
    }
  }
  EXPECT_GT(mixed_count, 100);
  EXPECT_LE(off_surface * 500, on_surface) << "surfaces seen at a grazing angle alone";

  VirtualScene kinect = make(options, kinect_sensor(), 5);
  (void)take(kinect, 3);
  kinect.mixed_mask(MaskImage(mixed.data(), kWidth, kHeight));
  EXPECT_EQ(std::count(mixed.begin(), mixed.end(), 0), kWidth * kHeight) << "its pixels see one surface each";
}

// Nothing stands before the person: a furnished room shows every pixel of the person an empty one shows.
TEST_F(VirtualCamera, FurnitureNeverHidesThePerson) {
  for (std::uint64_t i = 0; i < 20; ++i) {
    SceneOptions options;
    options.pose = i % 2 == 0 ? StandingPose::relaxed : StandingPose::free;
    VirtualScene bare = make(options, exact_sensor(), i);
    options.furniture_count = 4;
    VirtualScene furnished = make(options, exact_sensor(), i);
    EXPECT_EQ(take(bare, 0).mask, take(furnished, 0).mask) << i;
  }
}

TEST_F(VirtualCamera, GivenDistanceAndYawAreTaken) {
  SceneOptions options;
  options.distance_mm = 2750;
  options.camera_height_mm = 1100;
  options.pitch_deg = 0;
  options.yaw_deg = 30;
  options.sway = false;
  VirtualScene scene = make(options, kinect_sensor(), 2);
  EXPECT_FLOAT_EQ(scene.distance_mm(), 2750);
  EXPECT_FLOAT_EQ(scene.floor().camera_height_mm, 1100);
  const JointSet j = scene.joints(0);
  EXPECT_NEAR((j[Joint::LH].z + j[Joint::RH].z) / 2, 2750, 5);
  // Turned to the own left by 30 degrees: the left hip goes back.
  const Vec3f across = j[Joint::LH] - j[Joint::RH];
  EXPECT_NEAR(std::atan2(across.z, across.x) * 57.2958F, 30, 8);
}

}  // namespace
}  // namespace im2fit::lab
