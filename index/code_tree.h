// SPDX-License-Identifier: Apache-2.0
// Exact nearest neighbours among int8 codes, in arrays that are used where they lie in a mapped file.
//
// nanoflann's kd-tree cuts the points into leaves when the index is built; the file stores the points in the order of
// the leaves, the leaves' boxes, and boxes round groups of leaves. A search bounds its distance to all groups, then
// to the leaves of the groups that may matter, then scans those leaves (kernels/code_bounds, code_distance): no tree
// is walked, nothing is rebuilt when a file is opened, and the format does not depend on nanoflann's version.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/container.h"
#include "kernels/code_bounds/code_bounds.h"
#include "kernels/code_distance/code_distance.h"

namespace im2fit::index {

inline constexpr int kDimensionMax = kCodeDimensionMax;
inline constexpr int kNeighbourMax = 512;
inline constexpr int kStepMax = kCodeStepMax;                  // of one code, in units of the grid
inline constexpr std::int32_t kCoordinateMax = kCodePlaceMax;  // bound of a query coordinate
inline constexpr std::size_t kLeafMax = 128;                   // points
inline constexpr std::size_t kGroupLeaves = 64;                // whole blocks of boxes
static_assert(kGroupLeaves % kBoxBlock == 0);

using Coordinates = std::array<std::int32_t, kDimensionMax>;

struct Neighbour {
  std::int32_t distance = 0;  // squared, as kernels/code_distance defines it
  std::uint32_t index = 0;
  friend bool operator==(const Neighbour&, const Neighbour&) = default;
};

// Views; the code that makes them checks their sizes (format.cpp, or PackedTree of train/index).
struct CodeTree {
  std::size_t point_count = 0;
  int dimension_count = 0;
  Coordinates steps{};                        // 0..kStepMax; 0 from dimension_count on
  std::span<const std::int8_t> blocks;        // of 16 points, each of pair_count() pairs (kernels/code_distance)
  PagedBytes pages;                           // of a file: `blocks`, to be checked before they are read
  std::span<const std::uint32_t> leaf_first;  // per leaf its first point; then point_count
  std::span<const std::int16_t> leaf_boxes;   // blocks of 16 boxes (kernels/code_bounds), in units of the grid
  std::span<const std::int16_t> group_boxes;  // the same, of kGroupLeaves leaves each

  std::size_t leaf_count() const { return leaf_first.size() - 1; }
  std::size_t group_count() const { return (leaf_count() + kGroupLeaves - 1) / kGroupLeaves; }
  std::size_t pair_count() const { return static_cast<std::size_t>(dimension_count + 1) / 2; }
  int code(std::uint32_t point, std::size_t dimension) const {
    return blocks[((point / kCodeBlock) * pair_count() + dimension / 2) * 2 * kCodeBlock + point % kCodeBlock * 2 +
                  dimension % 2];
  }
  // Where in `blocks` those of a point's codes lie, and others' with them.
  ByteRange block_of(std::uint32_t point) const {
    const std::size_t size = pair_count() * 2 * kCodeBlock;
    return {point / kCodeBlock * size, size};
  }
};

// Sizes the arrays of a tree must have.
std::size_t code_block_bytes(std::size_t point_count, int dimension_count);
std::size_t box_values(std::size_t box_count, int dimension_count);

// What one thread needs to search a tree, whose arrays must outlive it.
class CodeSearch {
 public:
  explicit CodeSearch(const CodeTree& tree, std::size_t count_max = kNeighbourMax);
  // The min(count, point_count) nearest, nearest first, ties to the smaller index; count 1..count_max. Coordinates
  // are clamped to +-kCoordinateMax. The result is the caller's until the next call. No allocation.
  std::span<Neighbour> nearest(const Coordinates& query, std::size_t count);
  // The same by scanning every point: the reference, and faster for few points.
  std::span<Neighbour> exhaustive(const Coordinates& query, std::size_t count);
  // Whether the last search read undamaged codes; else its result must not be used.
  bool intact() const { return damaged_.count == 0; }
  Error damage() const { return tree_.pages.damage(damaged_); }
  // Of the last search: how much of the file it read.
  struct Work {
    std::size_t groups = 0, leaves = 0, points = 0;
  };
  const Work& work() const { return work_; }

 private:
  using Key = std::uint64_t;  // distance, then index: ordered as neighbours are
  void begin(std::size_t count);
  void search_group(std::size_t group, const CodeQuery& query);
  void scan(std::size_t first, std::size_t last, const CodeQuery& query);
  void offer(Key key);
  std::span<Neighbour> finish();

  CodeTree tree_;
  std::size_t count_max_;
  std::vector<std::int32_t> group_bounds_;
  std::vector<Key> groups_;
  std::vector<Key> found_;
  std::vector<Neighbour> result_;
  std::size_t count_ = 0;
  std::size_t found_count_ = 0;
  std::int32_t reach_ = 0;  // points farther than this are none of the nearest
  ByteRange damaged_;       // of the codes; count 0: none
  Work work_;
};

}  // namespace im2fit::index
