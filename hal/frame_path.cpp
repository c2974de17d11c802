// SPDX-License-Identifier: Apache-2.0
#include "hal/frame_path.h"

#include <chrono>
#include <string>
#include <utility>

namespace im2fit::hal {

UprightPath::UprightPath(const Intrinsics& camera, int rotate_deg)
    : camera_(camera),
      upright_(rotate_upright(camera, rotate_deg)),
      rotate_deg_(rotate_deg),
      pixels_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)) {}

Result<UprightPath> UprightPath::make(const Calibration& calibration, int rotate_deg, const std::string& what) {
  if (auto ok = check_intrinsics(calibration.intrinsics, what); !ok) return ok.error();
  UprightPath path(calibration.intrinsics, rotate_deg);
  if (!calibration.distortion.any()) return path;
  auto table = undistortion_table(calibration.intrinsics, calibration.distortion, what);
  if (!table) return table.error();
  path.undistortion_ = undistort_runs(*table);
  path.undistorted_.resize(table->size());
  return path;
}

void UprightPath::deliver(DepthImage out) {
  deliver(DepthView(pixels_.data(), camera_.width, camera_.height), out);
}

void UprightPath::deliver(DepthView camera_frame, DepthImage out) {
  if (undistortion_.empty()) {
    rotate_upright(camera_frame, rotate_deg_, out);
    return;
  }
  undistort(camera_frame.pixels, static_cast<int>(undistorted_.size()), undistortion_, undistorted_.data());
  rotate_upright(DepthView(undistorted_.data(), camera_.width, camera_.height), rotate_deg_, out);
}

Status UprightPath::check(const DepthImage& out, const std::string& what) const {
  if (out.pixels != nullptr && out.width == upright_.width && out.height == upright_.height &&
      out.stride >= out.width)
    return Ok{};
  return Error{ErrorCode::invalid_argument, what + ": the frame to fill is " + std::to_string(out.width) + "x" +
                                                std::to_string(out.height) + ", the source delivers " +
                                                std::to_string(upright_.width) + "x" +
                                                std::to_string(upright_.height) + "; use info().intrinsics' size"};
}

void SequenceBook::saw(std::uint64_t sequence) {
  if (stats_.delivered > 0) {
    if (sequence <= last_)
      ++stats_.repeats;
    else
      stats_.gaps += sequence - last_ - 1;
  }
  if (stats_.delivered == 0 || sequence > last_) last_ = sequence;
  ++stats_.delivered;
}

std::int64_t monotonic_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace im2fit::hal
