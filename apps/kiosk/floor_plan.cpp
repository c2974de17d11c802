// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/floor_plan.h"

#include <algorithm>
#include <vector>

#include "apps/kiosk/small_picture.h"

namespace im2fit::apps {
namespace {

constexpr int kAcrossPx = 320;                                    // pixels read along the longer side
constexpr float kFloorHalfMm = 60;                                // about the floor: its noise, and what lies on it
constexpr float kCeilingMm = 2300;                                // what is higher stands in nobody's way
constexpr std::array<std::uint8_t, 4> kGrey = {0, 70, 150, 255};  // by PlanCell

// As perception/segment places people for a region.
struct FloorAxes {
  Vec3f right, forward;
};
FloorAxes axes_of(Vec3f up) {
  const Vec3f ahead = Vec3f{0, 0, 1} - up * up.z;
  if (!(norm(ahead) > 0.1F)) return {{1, 0, 0}, {0, 0, 1}};  // the camera looks straight down
  const Vec3f forward = normalized(ahead);
  return {cross(forward, up), forward};
}

}  // namespace

FloorPlan floor_plan(DepthView depth, MaskView mask, const Intrinsics& k, const FloorPlane& floor) {
  FloorPlan plan;
  const FloorAxes axes = axes_of(floor.up);
  const int step = std::max(1, std::max(depth.width, depth.height) / kAcrossPx);
  for (int v = 0; v < depth.height; v += step)
    for (int u = 0; u < depth.width; u += step) {
      const std::uint16_t mm = depth.at(u, v);
      if (mm == 0) continue;
      const Vec3f p = unproject(k, static_cast<float>(u), static_cast<float>(v), static_cast<float>(mm));
      const float height = dot(floor.up, p) + floor.camera_height_mm;
      const float x = dot(axes.right, p) + kPlanHalfMm, z = dot(axes.forward, p);
      if (!(x >= 0 && z >= 0 && height < kCeilingMm)) continue;
      const float column = x / kPlanCellMm, row = z / kPlanCellMm;
      if (!(column < kPlanCells && row < kPlanCells)) continue;
      const bool person = mask.pixels != nullptr && mask.at(u, v) != 0;
      const PlanCell seen = person ? PlanCell::person : height < kFloorHalfMm ? PlanCell::floor : PlanCell::thing;
      PlanCell& cell = plan.at(static_cast<int>(column), static_cast<int>(row));
      cell = std::max(cell, seen);
    }
  return plan;
}

Result<std::string> picture_of(const FloorPlan& plan, bool people) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(plan.cells.size());
  for (int row = kPlanCells - 1; row >= 0; --row)
    for (int column = 0; column < kPlanCells; ++column) {
      const PlanCell cell = plan.at(column, row);
      const bool hidden = cell == PlanCell::person && !people;
      pixels.push_back(kGrey[static_cast<std::size_t>(hidden ? PlanCell::unseen : cell)]);
    }
  return grey_png(pixels, kPlanCells, kPlanCells);
}

}  // namespace im2fit::apps
