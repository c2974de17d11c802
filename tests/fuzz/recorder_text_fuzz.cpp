// SPDX-License-Identifier: Apache-2.0
// depth.txt and groundtruth.txt of a TUM folder and a frame_NNNNN.json of 3D Scanner App, as anyone may have written
// them: refused with one line, or times that grow and poses of unit length. The first byte chooses the file.
#include <cmath>
#include <cstdint>
#include <string>

#include "hal/folder/scanner_3d_app.h"
#include "hal/folder/tum_folder.h"

namespace {

void check(const im2fit::Error& error) {
  if (error.message.empty() || error.message.find('\n') != std::string::npos) __builtin_trap();
}

void check(const im2fit::hal::CameraPose& q) {
  if (!(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-4F)) __builtin_trap();
  if (!(norm(q.position_mm) < 2e6F)) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit::hal;
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  double last_s = -1;
  if (data[0] % 3 == 0) {
    const auto frames = parse_tum_frames(text, "depth.txt");
    if (!frames) return check(frames.error()), 0;
    for (const TumFrame& frame : *frames) {
      if (!(frame.time_s > last_s) || frame.file.empty() || frame.file.front() == '/') __builtin_trap();
      last_s = frame.time_s;
    }
  } else if (data[0] % 3 == 1) {
    const auto poses = parse_tum_poses(text, "groundtruth.txt");
    if (!poses) return check(poses.error()), 0;
    for (const TumPose& row : *poses) {
      if (!(row.time_s > last_s)) __builtin_trap();
      last_s = row.time_s;
      check(row.pose);
    }
  } else {
    const auto row = parse_app_frame(text, "frame_00000.json");
    if (!row) return check(row.error()), 0;
    check(row->pose);
    if (!row->lens || !row->time_s || !((*row->lens)[0] > 0)) __builtin_trap();
  }
  return 0;
}
