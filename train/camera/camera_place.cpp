// SPDX-License-Identifier: Apache-2.0
#include "train/camera/camera_place.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace im2fit::lab {

using body::Mat3f;

Mat3f mounting(int rotate_deg) {
  switch (rotate_deg) {
    case 90:
      return {{0, 1, 0, -1, 0, 0, 0, 0, 1}};
    case 180:
      return {{-1, 0, 0, 0, -1, 0, 0, 0, 1}};
    case 270:
      return {{0, -1, 0, 1, 0, 0, 0, 0, 1}};
    default:
      return {};
  }
}

namespace {

constexpr float kFitMarginShare = 0.02F;  // of the picture's width, free at every border
constexpr float kDistanceMaxMm = 4500;
constexpr std::uint64_t kSceneStream = 0x5C01;

// The whole person inside the picture with a margin, at every sway.
bool fits(const CameraPlace& camera, int rotate_deg, std::span<const Vec3f> person, const Intrinsics& intrinsics) {
  const Rigid to_sensor = Rigid{mounting(rotate_deg), {}} * camera.world_to_upright();
  const float margin = kFitMarginShare * static_cast<float>(intrinsics.width);
  for (const Vec3f& world : person) {
    const Vec3f p = to_sensor(world);
    if (p.z < kNearMm) return false;
    const float u = p.x * intrinsics.fx / p.z + intrinsics.cx;
    const float v = p.y * intrinsics.fy / p.z + intrinsics.cy;
    if (u < margin || v < margin || u > static_cast<float>(intrinsics.width - 1) - margin ||
        v > static_cast<float>(intrinsics.height - 1) - margin)
      return false;
  }
  return true;
}

}  // namespace

Intrinsics kinect_intrinsics(int width, int height) {
  const float f = kKinectFocalPx * static_cast<float>(width) / 640;
  return {width, height, f, f, (static_cast<float>(width) - 1) / 2, (static_cast<float>(height) - 1) / 2};
}

Vec3f upright_to_sensor(Vec3f p, int rotate_deg) {
  return mounting(rotate_deg) * p;
}

CameraPlace place_camera(const SceneOptions& scene, std::span<const Vec3f> person, const Intrinsics& sensor,
                         std::uint64_t seed) {
  CameraPlace camera;
  Rng rng = Rng::for_item(seed, kSceneStream, 0);
  const bool portrait = scene.rotate_deg == 90 || scene.rotate_deg == 270;
  const auto draw = [&](double low, double high) { return static_cast<float>(rng.uniform(low, high)); };
  const float distance = portrait ? draw(2000, 2600) : draw(2400, 3200);
  const float height = draw(800, 1200);
  const float aside = std::clamp(static_cast<float>(rng.normal(0, 80)), -160.0F, 160.0F);
  const float aim = static_cast<float>(rng.normal(0, 1.2));
  camera.roll_deg = static_cast<float>(rng.normal(0, 0.7));
  camera.aside_mm = aside;
  camera.height_mm = scene.camera_height_mm > 0 ? scene.camera_height_mm : height;
  camera.distance_mm = scene.distance_mm > 0 ? scene.distance_mm : distance;
  float top = 0;
  for (const Vec3f& p : person) top = std::max(top, p.y);
  const auto aim_camera = [&] {
    const float middle = std::atan2(camera.height_mm - top / 2, camera.distance_mm) * 180 / std::numbers::pi_v<float>;
    const float drawn = std::clamp(middle + aim, -scene.pitch_limit_deg, scene.pitch_limit_deg);
    camera.pitch_deg = scene.pitch_deg > kDrawnDeg ? drawn : scene.pitch_deg;
  };
  aim_camera();
  const bool enlarge = scene.distance_mm <= 0 || scene.enlarge_to_fit;
  while (enlarge && camera.distance_mm < kDistanceMaxMm && !fits(camera, scene.rotate_deg, person, sensor)) {
    camera.distance_mm *= 1.03F;
    aim_camera();
  }
  return camera;
}

}  // namespace im2fit::lab
