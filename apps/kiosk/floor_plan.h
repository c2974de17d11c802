// SPDX-License-Identifier: Apache-2.0
// What the camera sees of the floor and on it, from above: on it the operator draws where to measure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/camera.h"
#include "core/floor_plane.h"
#include "core/status.h"

namespace im2fit::apps {

// Square cells; x to the right as the camera sees it, from -kPlanHalfMm; z away from the camera, from 0.
// web/operator.js has the same numbers.
inline constexpr int kPlanCells = 120;
inline constexpr int kPlanCellMm = 50;
inline constexpr int kPlanHalfMm = kPlanCells * kPlanCellMm / 2;

enum class PlanCell : std::uint8_t { unseen, floor, thing, person };

struct FloorPlan {
  std::array<PlanCell, static_cast<std::size_t>(kPlanCells) * kPlanCells> cells{};  // rows by z, nearest first
  PlanCell& at(int column, int row) {
    return cells[static_cast<std::size_t>(row) * kPlanCells + static_cast<std::size_t>(column)];
  }
  PlanCell at(int column, int row) const {
    return cells[static_cast<std::size_t>(row) * kPlanCells + static_cast<std::size_t>(column)];
  }
};

// `floor` is known. `mask` as small_picture(). Of a cell with floor and more, the more.
FloorPlan floor_plan(DepthView depth, MaskView mask, const Intrinsics& k, const FloorPlane& floor);
// A PNG, a pixel a cell, the farthest row first. `people`: else their cells are as unseen.
Result<std::string> picture_of(const FloorPlan& plan, bool people);

}  // namespace im2fit::apps
