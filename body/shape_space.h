// SPDX-License-Identifier: Apache-2.0
// How bodies differ, as a few numbers: points of the skin and the bones as linear functions of shape coefficients,
// the principal components of a population (train/population/shape_space_builder). What a fit to a depth picture
// searches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "body/model.h"
#include "kernels/skin/skin.h"

namespace im2fit::body {

inline constexpr std::size_t kShapeMax = 64;
inline constexpr std::size_t kShapePointMin = 100, kShapePointMax = 10000;

// A point of the skin is the middle of a quad; its diagonals give the normal.
inline constexpr std::size_t kPointValues = 9;                                           // middle, two diagonals
inline constexpr std::size_t kBoneValues = static_cast<std::size_t>(kSegmentCount) * 6;  // heads, then tails

// Rest pose, mesh axes, mm. A value is mean + sum of coefficient x basis; coefficients have unit variance.
// Of a body file (body/shape_space_file.h): 1 to kShapeMax shapes, kShapePointMin to kShapePointMax points, all
// values finite, weights that sum to 1. point_count 0: the file has none.
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

}  // namespace im2fit::body
