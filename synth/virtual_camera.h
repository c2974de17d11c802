// SPDX-License-Identifier: Apache-2.0
// A depth camera looking at a room: z-buffer, Kinect intrinsics, structured-light noise (Nguyen 2012),
// disparity quantisation (Khoshelham 2012), shadow, holes, floor, wall, furniture.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "body/skeleton.h"
#include "kernels/core/camera.h"
#include "kernels/core/joints.h"
#include "kernels/segment/segment.h"
#include "synth/population.h"

namespace im2fit::synth {

inline constexpr float kKinectFocalPx = 575.8F;  // depth camera, 640 px wide (not 525: that is registered depth)
Intrinsics kinect_intrinsics(int width, int height);  // landscape 640x480 or 320x240

enum class StandingPose { relaxed, a_pose, psi, free };

struct SceneOptions {
  bool floor = true;
  bool wall = true;
  int furniture_count = 0;       // boxes, tables, chairs about the person, not in front of the person
  float wall_distance_mm = 0;    // 0: drawn
  float distance_mm = 0;         // camera to person along the floor; 0: drawn so that the whole person fits
  float camera_height_mm = 0;    // 0: drawn 800..1200
  float pitch_deg = 1e9F;        // 1e9: drawn, small
  float yaw_deg = 1e9F;          // of the person; 1e9: drawn by pose class
  StandingPose pose = StandingPose::relaxed;
  int rotate_deg = 90;           // camera mounting, 0|90|180|270: the image is rendered as the sensor delivers it
  bool back_view = false;
};

struct SensorOptions {
  bool noise = true;      // false: exact depth rounded to mm
  bool quantise = true;
  bool shadow = true;
  bool holes = true;
};

// A scene drawn once; frames differ by sensor noise and by sway.
class VirtualScene {
 public:
  VirtualScene(const body::BodyModel& model, const Subject& subject, const SceneOptions& scene,
               const SensorOptions& sensor, const Intrinsics& intrinsics, std::uint64_t seed);
  ~VirtualScene();
  VirtualScene(VirtualScene&&) noexcept;

  // Frame `index`: depends on the scene's seed and the index only. Depth as the sensor delivers it: `intrinsics`
  // size, before any --rotate.
  void render(std::uint64_t index, DepthImage out);
  const Intrinsics& intrinsics() const;
  // Truth in camera axes of the *upright* image, the one the program sees after undoing rotate_deg.
  JointSet joints(std::uint64_t index) const;
  FloorPlane floor() const;
  // Mask of the person, upright or not like render()'s output, of the frame rendered last.
  void person_mask(MaskImage out) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace im2fit::synth
