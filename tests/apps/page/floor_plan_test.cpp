// SPDX-License-Identifier: Apache-2.0
// A room from above: a floor, a wall 4 m away, a person 2 m away, a crate beside; seen by a camera that looks down.
#include "apps/kiosk/floor_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace im2fit {
namespace {

using apps::PlanCell;

constexpr int kWidth = 320, kHeight = 240;
constexpr Intrinsics kK = {kWidth, kHeight, 290, 290, 159.5F, 119.5F};
constexpr float kCameraMm = 900;

struct Seen {
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kWidth * kHeight);
  std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(kWidth * kHeight);
  FloorPlane floor;
  // Camera axes: x right, y down, z forward; level but for the pitch.
  explicit Seen(float pitch) {
    const float c = std::cos(pitch), s = std::sin(pitch);
    floor = {true, {0, -c, -s}, kCameraMm};
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u) {
        const Vec3f ray = unproject(kK, static_cast<float>(u), static_cast<float>(v), 1);
        const float down = ray.y * c + ray.z * s, ahead = ray.z * c - ray.y * s;
        float t = 4000 / ahead;                                                  // the wall
        const auto nearer = [&](float at, float left, float right, float top) {  // an upright board
          const float way = at / ahead, x = ray.x * way, height = kCameraMm - down * way;
          if (way > t || x < left || x > right || height > top || height < 0) return false;
          t = way;
          return true;
        };
        if (down > 0) t = std::min(t, kCameraMm / down);
        const bool person = nearer(2000, -200, 200, 1700);
        nearer(2500, 700, 1000, 500);
        const auto i = static_cast<std::size_t>(v * kWidth + u);
        depth[i] = static_cast<std::uint16_t>(std::lround(t));
        mask[i] = person && t == 2000 / ahead ? 255 : 0;
      }
  }
  apps::FloorPlan plan() const {
    return apps::floor_plan(DepthView(depth.data(), kWidth, kHeight), MaskView(mask.data(), kWidth, kHeight), kK,
                            floor);
  }
};

PlanCell at(const apps::FloorPlan& plan, float x_mm, float z_mm) {
  return plan.at(static_cast<int>((x_mm + apps::kPlanHalfMm) / apps::kPlanCellMm),
                 static_cast<int>(z_mm / apps::kPlanCellMm));
}

TEST(FloorPlan, WhatStandsWhereOnTheFloor) {
  for (const float pitch : {0.0F, 0.2F}) {
    const apps::FloorPlan plan = Seen(pitch).plan();
    EXPECT_EQ(at(plan, 0, 2010), PlanCell::person) << pitch;
    EXPECT_EQ(at(plan, 850, 2510), PlanCell::thing) << pitch;
    EXPECT_EQ(at(plan, -850, 2510), PlanCell::floor) << pitch << ": left and right are not mixed up";
    EXPECT_EQ(at(plan, 400, 3010), PlanCell::floor) << pitch;
    EXPECT_EQ(at(plan, 500, 4010), PlanCell::thing) << pitch;
    EXPECT_EQ(at(plan, 0, 4510), PlanCell::unseen) << pitch << ": behind the wall";
    EXPECT_EQ(at(plan, 0, 510), PlanCell::unseen) << pitch << ": below the picture";
  }
}

TEST(FloorPlan, NoDepthAndFarthestValuesAreNowhere) {
  Seen seen(0);
  for (const std::uint16_t mm : {std::uint16_t{0}, std::numeric_limits<std::uint16_t>::max()}) {
    std::fill(seen.depth.begin(), seen.depth.end(), mm);
    const apps::FloorPlan plan = seen.plan();
    EXPECT_TRUE(std::all_of(plan.cells.begin(), plan.cells.end(), [](PlanCell c) { return c == PlanCell::unseen; }));
  }
}

TEST(FloorPlan, APictureWithoutPeopleShowsTheRoom) {
  apps::FloorPlan plan = Seen(0.1F).plan();
  const auto with = apps::picture_of(plan, true), without = apps::picture_of(plan, false);
  ASSERT_TRUE(with && without);
  EXPECT_EQ(with->substr(1, 3), "PNG");
  EXPECT_NE(*with, *without);
  std::replace(plan.cells.begin(), plan.cells.end(), PlanCell::person, PlanCell::unseen);
  EXPECT_EQ(*apps::picture_of(plan, true), *without);
}

}  // namespace
}  // namespace im2fit
