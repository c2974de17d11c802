// SPDX-License-Identifier: Apache-2.0
// Scans in PLY, OBJ, GLB and PCD as anyone may have written them: refused in one line, or points that are finite and
// triangles of these, which then stand and are drawn, or are refused. The first byte chooses the
// format, whether a unit is given, and whether an axis is.
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/scan/scan_camera.h"
#include "hal/scan/scan_readers.h"
#include "hal/scan/standing_scan.h"
#include "recording_use.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit::hal;
  if (size == 0) return 0;
  constexpr decltype(&read_ply) kReaders[] = {read_ply, read_obj, read_glb, read_pcd};
  const auto bytes = std::as_bytes(std::span(data + 1, size - 1));
  auto raw = kReaders[data[0] % 4](bytes, "a scan");
  if (!raw) return im2fit::fuzz::check_one_line(raw.error()), 0;
  // A node that many others name may repeat its points, but not without end.
  if (raw->points.size() > kScanPointsMax || raw->triangles.size() > kScanTrianglesMax + 1) __builtin_trap();
  auto scan = checked_scan(std::move(*raw), "a scan");
  if (!scan) return im2fit::fuzz::check_one_line(scan.error()), 0;
  for (const im2fit::Vec3f p : scan->points)
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) __builtin_trap();
  for (const ScanTriangle& t : scan->triangles)
    for (const std::uint32_t corner : t)
      if (corner >= scan->points.size()) __builtin_trap();
  auto stood =
      stand_scan(std::move(*scan), {(data[0] & 4U) != 0 ? 1.0 : 0.0, (data[0] & 8U) != 0 ? "y" : ""}, "a scan");
  if (!stood) return im2fit::fuzz::check_one_line(stood.error()), 0;
  ScanCamera camera(std::move(*stood));
  const im2fit::Intrinsics k = ScanCamera::intrinsics();
  std::vector<std::uint16_t> picture(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  camera.render(30, {picture.data(), k.width, k.height});
  return 0;
}
