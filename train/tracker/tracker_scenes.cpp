// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_scenes.h"

#include <algorithm>
#include <cmath>

#include "hal/source.h"

namespace im2fit::lab {
namespace {

constexpr int kOthersPool = 16;            // few enough that a VirtualScene remembers them
constexpr std::uint64_t kOthersSeed = 77;  // subjects apart from those the caller draws
constexpr float kPitchMostDeg = 20;

float draw(Rng& rng, double low, double high) {
  return static_cast<float>(rng.uniform(low, high));
}
bool chance(Rng& rng, double share) {
  return rng.uniform() < share;
}
float either(Rng& rng, double low, double high) {
  return rng.index(2) == 0 ? draw(rng, low, high) : -draw(rng, low, high);
}

PoseClass draw_class(const TrackerMix& mix, Rng& rng) {
  double sum = 0;
  for (const double w : mix.pose_weight) sum += w;
  double left = rng.uniform() * sum;
  for (std::size_t i = 0; i < kPoseClassCount; ++i) {
    left -= mix.pose_weight[i];
    if (left < 0) return static_cast<PoseClass>(i);
  }
  return PoseClass::calm;
}

StandingPose calm_pose(Rng& rng) {
  return chance(rng, 0.65) ? StandingPose::relaxed : StandingPose::a_pose;
}

void draw_pose_of(const TrackerMix& mix, PoseClass kind, Rng& rng, SceneOptions& scene) {
  switch (kind) {
    case PoseClass::psi:
      scene.pose = StandingPose::psi;
      break;
    case PoseClass::free:
      scene.pose = StandingPose::free;
      break;
    case PoseClass::crossed:
      scene.pose = StandingPose::crossed;
      break;
    case PoseClass::seated:
      scene.pose = StandingPose::seated;
      break;
    case PoseClass::turned:
      scene.pose = chance(rng, 0.5) ? StandingPose::free : calm_pose(rng);
      scene.yaw_deg = either(rng, 20, mix.turned_max_deg);
      break;
    case PoseClass::bowed:
      scene.pose = StandingPose::bowed;
      break;
    default:
      scene.pose = calm_pose(rng);
  }
}

Clothing draw_clothing(double share, Rng& rng) {
  if (!chance(rng, share)) return Clothing::none;
  const double kind = rng.uniform();
  return kind < 0.2 ? Clothing::tight : kind < 0.7 ? Clothing::normal : Clothing::loose;
}

void draw_others(const TrackerMix& mix, Family family, Rng& rng, SceneOptions& scene) {
  const int count = 1 + (chance(rng, 0.3) ? 1 : 0);
  for (int i = 0; i < count; ++i) {
    Bystander other;
    other.family = family;
    other.subject_seed = kOthersSeed;
    other.subject_index = static_cast<std::uint64_t>(rng.index(kOthersPool));
    other.pose = chance(rng, 0.5) ? StandingPose::relaxed : StandingPose::free;
    other.clothing = draw_clothing(mix.clothed_share, rng);
    other.hair = chance(rng, mix.hair_share);
    if (chance(rng, 0.5)) other.yaw_deg = draw(rng, -180, 180);
    // Beside, no nearer than a shoulder's width from the shoulders, or behind and partly hidden.
    other.path.from_x_mm = either(rng, 250, 1300);
    const bool beside = std::fabs(other.path.from_x_mm) > 750;
    other.path.from_z_mm = beside ? draw(rng, -1200, 250) : draw(rng, -1600, -700);
    scene.others.push_back(other);
  }
}

void draw_camera(const TrackerMix& mix, Rng& rng, SceneOptions& scene) {
  const double mount = rng.uniform();
  if (mount < mix.portrait_share)
    scene.rotate_deg = mount < 0.8 * mix.portrait_share ? 90 : 270;
  else
    scene.rotate_deg = mount < 1 - 0.1 * (1 - mix.portrait_share) ? 0 : 180;
  const bool cut = chance(rng, mix.cut_share);
  const float height = draw(rng, 500, 2200), near = draw(rng, 1000, 4000), close = draw(rng, 1000, 2300);
  if (mix.wide_share >= 1 || (mix.wide_share > 0 && chance(rng, mix.wide_share))) {
    scene.camera_height_mm = height;
    scene.pitch_limit_deg = kPitchMostDeg;
    scene.distance_mm = cut ? close : near;
    scene.enlarge_to_fit = !cut;
  } else if (cut) {
    scene.distance_mm = close;
  }
}

}  // namespace

TrackerMix training_mix() {
  TrackerMix mix;
  // A person turned or bent is not measured but must still be detected, to get the right guidance.
  mix.pose_weight = {0.25, 0.07, 0.32, 0.11, 0.08, 0.11, 0.06};
  mix.turned_max_deg = 85;
  mix.clothed_share = 0.75;
  mix.hair_share = 0.7;
  mix.back_share = 0.15;
  mix.furniture_share = 0.5;
  mix.touching_share = 0.3;
  mix.decoy_share = 0.25;
  mix.others_share = 0.12;
  mix.cut_share = 0.12;
  mix.tof_share = 0.3;
  mix.vga_share = 0.15;
  mix.wide_share = 0.5;
  return mix;
}

TrackerMix full_conditions_mix() {
  TrackerMix mix;
  mix.pose_weight = {0.35, 0.10, 0.30, 0.09, 0.08, 0.08, 0};
  mix.clothed_share = 1;
  mix.hair_share = 1;
  mix.furniture_share = 0.7;
  mix.touching_share = 0.2;
  mix.decoy_share = 0.2;
  mix.others_share = 0.1;
  mix.tof_share = 0.3;
  mix.vga_share = 0.5;
  return mix;
}

TrackerMix bare_mix() {
  TrackerMix mix;
  mix.pose_weight = {0.375, 0.125, 0.5, 0, 0, 0, 0};
  return mix;
}

TrackerMix person_mix() {
  TrackerMix mix = training_mix();
  mix.pose_weight = {0.2, 0.04, 0.25, 0.1, 0.08, 0.2, 0.13};
  return mix;
}

void TrackerScene::place(const VirtualScene& staged) {
  distance_mm = staged.distance_mm();
  camera_height_mm = staged.floor().camera_height_mm;
  const Intrinsics k = hal::rotate_upright(staged.intrinsics(), rotate_deg);
  const JointSet joints = staged.joints(0);
  whole = std::all_of(joints.position_mm.begin(), joints.position_mm.end(), [&](const Vec3f& p) {
    if (p.z < kNearMm) return false;
    const float u = p.x * k.fx / p.z + k.cx, v = p.y * k.fy / p.z + k.cy;
    return u >= 0 && v >= 0 && u <= static_cast<float>(k.width - 1) && v <= static_cast<float>(k.height - 1);
  });
}

TrackerScene draw_tracker_scene(const TrackerMix& mix, Rng& rng, Family family) {
  TrackerScene t;
  t.seed = rng.next();
  SceneOptions& scene = t.scene;
  scene.sway = false;
  t.pose_class = draw_class(mix, rng);
  draw_pose_of(mix, t.pose_class, rng, scene);
  scene.back_view = chance(rng, mix.back_share) && t.pose_class != PoseClass::seated;
  scene.clothing = draw_clothing(mix.clothed_share, rng);
  scene.hair = chance(rng, mix.hair_share);
  draw_camera(mix, rng, scene);
  scene.wall = chance(rng, 0.85);
  t.furnished = chance(rng, mix.furniture_share);
  if (t.furnished) {
    scene.furniture_count = 1 + rng.index(4);
    scene.furniture_touching = chance(rng, mix.touching_share);
    scene.decoy_count = chance(rng, mix.decoy_share) ? 1 + rng.index(2) : 0;
  }
  if (chance(rng, mix.others_share)) draw_others(mix, family, rng, scene);
  const bool tof = chance(rng, mix.tof_share), vga = chance(rng, mix.vga_share);
  if (mix.noise)
    t.sensor = tof ? tof_sensor() : kinect_sensor();
  else
    t.sensor = exact_sensor();
  t.intrinsics = vga ? kinect_intrinsics(640, 480) : kinect_intrinsics(320, 240);

  t.back_view = scene.back_view;
  t.clothing = scene.clothing;
  t.kind = t.sensor.kind;
  t.rotate_deg = scene.rotate_deg;
  t.others = static_cast<int>(scene.others.size());
  return t;
}

TrackerScene draw_empty_room(Rng& rng) {
  TrackerScene t;
  t.seed = rng.next();
  t.sensor = chance(rng, 0.3) ? tof_sensor() : kinect_sensor();
  t.intrinsics = chance(rng, 0.15) ? kinect_intrinsics(640, 480) : kinect_intrinsics(320, 240);
  SceneOptions& scene = t.scene;
  scene.person = scene.sway = false;
  scene.rotate_deg = chance(rng, 0.5) ? 90 : 0;
  scene.camera_height_mm = draw(rng, 500, 2200);
  scene.pitch_limit_deg = kPitchMostDeg;
  scene.wall = chance(rng, 0.85);
  scene.furniture_count = rng.index(6);
  scene.decoy_count = chance(rng, 0.85) ? 1 + rng.index(4) : 0;

  t.furnished = true;
  t.kind = t.sensor.kind;
  t.rotate_deg = scene.rotate_deg;
  return t;
}

}  // namespace im2fit::lab
