// SPDX-License-Identifier: Apache-2.0
#include "hal/scan/scan_source.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>

#include "hal/scan/scan_camera.h"
#include "hal/synthetic_source.h"

namespace im2fit::hal {
namespace {

float yaw_deg(std::uint64_t frame) {
  const float way = (static_cast<float>(frame) - kScanFrontFrames) / kScanRoundFrames;
  return 360 * std::clamp(way, 0.0F, 1.0F);
}

std::string words_of(const StandingScan& scan, const std::string& path) {
  char text[120];
  std::snprintf(text, sizeof text, " (scan of %.0f mm, %g mm a unit, %s up%s, %s)",
                static_cast<double>(scan.height_mm), scan.unit_mm, scan.up.c_str(),
                scan.straightened ? ", straightened" : "", scan.triangles.empty() ? "points" : "mesh");
  return path + text;
}

}  // namespace

Result<std::unique_ptr<Source>> open_scan(const std::string& path, const ScanOptions& options) {
  auto scan = read_scan(path);
  if (!scan) return scan.error();
  auto standing = stand_scan(std::move(*scan), options, path);
  if (!standing) return standing.error();
  SourceInfo info;
  info.uri = path;
  info.name = words_of(*standing, path);
  info.frame_count = kScanFrontFrames + kScanRoundFrames + kScanEndFrames;
  const auto camera = std::make_shared<ScanCamera>(std::move(*standing));
  auto source = SyntheticSource::create(
      ScanCamera::intrinsics(), std::move(info),
      [camera](std::uint64_t frame, DepthImage out) {
        camera->render(yaw_deg(frame), out);
        return true;
      },
      [](std::uint64_t frame) { return ScanCamera::pose(yaw_deg(frame)); });
  if (!source) return source.error();
  return std::unique_ptr<Source>(std::move(*source));
}

}  // namespace im2fit::hal
