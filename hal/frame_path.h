// SPDX-License-Identifier: Apache-2.0
// Common steps of all sources for each frame: correct the lens, rotate the picture upright, count its number.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/intrinsics.h"
#include "hal/source.h"
#include "hal/undistort.h"

namespace im2fit::hal {

// Rotates the camera's picture upright. Allocates only in the constructor.
class UprightPath {
 public:
  UprightPath() = default;
  UprightPath(const Intrinsics& camera, int rotate_deg);
  // Checks the calibration and also corrects its lens distortion. `what` names the file or device.
  static Result<UprightPath> make(const Calibration& calibration, int rotate_deg, const std::string& what);

  const Intrinsics& camera() const { return camera_; }
  const Intrinsics& upright() const { return upright_; }
  int rotate_deg() const { return rotate_deg_; }
  std::size_t pixel_count() const { return pixels_.size(); }
  // A buffer of the camera's size. Fill it before deliver().
  DepthImage camera_image() { return {pixels_.data(), camera_.width, camera_.height}; }
  void deliver(DepthImage out);                          // from camera_image()
  void deliver(DepthView camera_frame, DepthImage out);  // `camera_frame` without padding between its rows
  // Checks that the destination of next() has the upright size.
  Status check(const DepthImage& out, const std::string& what) const;

 private:
  Intrinsics camera_;
  Intrinsics upright_;
  int rotate_deg_ = 0;
  std::vector<std::uint16_t> pixels_;
  std::vector<UndistortRun> undistortion_;  // empty for a lens without distortion
  std::vector<std::uint16_t> undistorted_;
};

class SequenceBook {
 public:
  void reset() { *this = {}; }
  void saw(std::uint64_t sequence);
  void damaged() { ++stats_.damaged; }
  const SourceStats& stats() const { return stats_; }

 private:
  SourceStats stats_;
  std::uint64_t last_ = 0;
};

std::int64_t monotonic_ns();

}  // namespace im2fit::hal
