// SPDX-License-Identifier: Apache-2.0
// Depth pictures of a scan that stands, as a camera carried round the person would take them.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "hal/scan/standing_scan.h"
#include "hal/source.h"

namespace im2fit::hal {

// Not shareable between threads.
class ScanCamera {
 public:
  explicit ScanCamera(StandingScan scan);

  // A picture in portrait of a whole person of up to 2.3 m.
  static Intrinsics intrinsics();
  // From the front at 0; from the person's left at 90. Depth in mm, the floor about the person included; 0: nothing,
  // or a hole of the scan.
  void render(float yaw_deg, DepthImage out);
  // Of the camera that took it, in the axes of the one at 0.
  static CameraPose pose(float yaw_deg);

 private:
  void draw_triangles();
  void draw_points();

  StandingScan scan_;
  bool two_sided_ = false;             // its faces do not agree about where outside is
  int reach_px_ = 0;                   // of a cloud: half of the widest gap between points
  std::vector<Vec3f> seen_;            // of each point: u, v, z
  std::vector<float> nearest_, kept_;  // of each pixel, mm; 0: nothing
  std::vector<std::uint8_t> back_;     // of each pixel: what is nearest is the inside of the surface
};

}  // namespace im2fit::hal
