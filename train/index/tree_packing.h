// SPDX-License-Identifier: Apache-2.0
// Cuts int8 codes into leaves and lays them out as index/code_tree.h searches them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "index/code_tree.h"

namespace im2fit::index {

// A tree as the builder makes it.
struct PackedTree {
  std::vector<std::uint32_t> order;  // of each stored point, its row in the codes given
  std::vector<std::int8_t> blocks;
  std::vector<std::uint32_t> leaf_first;
  std::vector<std::int16_t> leaf_boxes, group_boxes;
  Coordinates steps{};
  int dimension_count = 0;
  CodeTree view() const;
};
// `codes`: dimension_count per point, at least one point. Deterministic.
PackedTree pack_tree(std::span<const std::int8_t> codes, int dimension_count, const Coordinates& steps);

}  // namespace im2fit::index
