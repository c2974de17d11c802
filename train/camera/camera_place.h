// SPDX-License-Identifier: Apache-2.0
// Where the camera of a scene is: drawn or given, pointed at the person.
#pragma once

#include <cstdint>
#include <span>

#include "train/camera/virtual_camera.h"
#include "train/render/scene_axes.h"

namespace im2fit::lab {

inline constexpr float kDrawnDeg = 1e8F;  // angles above this are to be drawn

body::Mat3f mounting(int rotate_deg);  // upright camera axes to the sensor's own

// World (y up, z towards the camera, origin on the floor under the person) to the upright camera.
struct CameraPlace {
  float distance_mm = 2300, height_mm = 1000, aside_mm = 0, pitch_deg = 0, roll_deg = 0;
  body::Mat3f rotation() const {
    const body::Mat3f level{{1, 0, 0, 0, -1, 0, 0, 0, -1}};
    return body::rotation_about(kAxisZ, roll_deg) * body::rotation_about(kAxisX, pitch_deg) * level;
  }
  Rigid world_to_upright() const {
    const body::Mat3f r = rotation();
    return {r, r * Vec3f{-aside_mm, -height_mm, -distance_mm}};
  }
};
CameraPlace place_camera(const SceneOptions& scene, std::span<const Vec3f> person, const Intrinsics& sensor,
                         std::uint64_t seed);

}  // namespace im2fit::lab
