// SPDX-License-Identifier: Apache-2.0
// How bodies differ, as a few numbers: points of the skin and the bones as linear functions of shape coefficients,
// the principal components of a population (train/population/shape_space_builder). What a fit to a depth picture
// searches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "body/model.h"
#include "core/container.h"
#include "core/status.h"
#include "kernels/skin/skin.h"

namespace im2fit::body {

inline constexpr std::size_t kShapeMax = 64;
inline constexpr std::size_t kShapePointMin = 100, kShapePointMax = 10000;

// A point of the skin is the middle of a quad; its diagonals give the normal.
inline constexpr std::size_t kPointValues = 9;                                           // middle, two diagonals
inline constexpr std::size_t kBoneValues = static_cast<std::size_t>(kSegmentCount) * 6;  // heads, then tails

// Rest pose, mesh axes, mm. A value is mean + sum of coefficient x basis; coefficients have unit variance.
// Of a body file: 1 to kShapeMax shapes, kShapePointMin to kShapePointMax points, all values finite, weights that sum
// to 1. point_count 0: the file has none.
struct ShapeSpace {
  std::size_t shape_count = 0;
  std::size_t point_count = 0;
  std::vector<float> point_mean;   // point x kPointValues
  std::vector<float> point_basis;  // point x kPointValues x shape
  std::vector<SkinRecord> skin;    // of each point
  std::vector<float> bone_mean;    // kBoneValues
  std::vector<float> bone_basis;   // kBoneValues x shape
  std::uint32_t key = 0;           // of the file's sections: coefficients of another space mean something else
};

// The shape space inside a body file: sections shape_* (docs/formats-body.md). Points are stored in 16 bits with a
// scale a component, so a space that was read differs from the one written by half a step (0.02 mm of a mean point,
// thousandths of a component) and is the same on every machine.

// The space of a parsed body file, checked; one of no points when the file has no section shape_about.
Result<ShapeSpace> read_shape_space(const ContainerReader& reader, const std::string& what);

// The body file `pack` with its shape sections replaced by those of `space`. Errors: as read_shape_space.
Result<std::vector<std::byte>> with_shape_space(std::span<const std::byte> pack, const ShapeSpace& space);

}  // namespace im2fit::body
