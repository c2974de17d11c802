// SPDX-License-Identifier: Apache-2.0
// What every source does with a frame at the edge: turn it upright and keep the books on sequence numbers.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/source.h"

namespace im2fit::hal {

// The camera's picture on its way to upright; allocates only when made.
class UprightPath {
 public:
  UprightPath() = default;
  UprightPath(const Intrinsics& camera, int rotate_deg);

  const Intrinsics& camera() const { return camera_; }
  const Intrinsics& upright() const { return upright_; }
  int rotate_deg() const { return rotate_deg_; }
  std::size_t pixel_count() const { return pixels_.size(); }
  // A buffer of the camera's size to fill before deliver().
  DepthImage camera_image() { return {pixels_.data(), camera_.width, camera_.height}; }
  void deliver(DepthImage out) const;  // from camera_image()
  void deliver(DepthView camera_frame, DepthImage out) const { rotate_upright(camera_frame, rotate_deg_, out); }
  // The destination handed to next() has the upright size.
  Status check(const DepthImage& out, const std::string& what) const;

 private:
  Intrinsics camera_;
  Intrinsics upright_;
  int rotate_deg_ = 0;
  std::vector<std::uint16_t> pixels_;
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
