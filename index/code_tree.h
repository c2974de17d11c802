// SPDX-License-Identifier: Apache-2.0
// Exact nearest neighbours among int8 codes. nanoflann's kd-tree cuts the points into leaves; a search bounds the
// distance to every leaf's box at once, then scans the leaves that may matter (kernels/code_bounds, code_distance).
// Measured with 512 of 18,461 neighbours in 12 dimensions: a fifth of the points is scanned, and a scan of a leaf
// costs less than walking the tree down to it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kernels/code_distance/code_distance.h"

namespace im2fit::index {

inline constexpr int kDimensionMax = kCodeDimensionMax;  // codes are padded to this with zeros
inline constexpr int kNeighbourMax = 512;
inline constexpr int kStepMax = kCodeStepMax;  // of one code, in units of the common grid
// Bound of a query coordinate; squared distances stay below 2^45.
inline constexpr std::int32_t kCoordinateMax = kCodePlaceMax;

using Coordinates = std::array<std::int32_t, kDimensionMax>;

struct Neighbour {
  std::int64_t distance = 0;  // squared, in units of the common grid
  std::uint32_t index = 0;
  // Ties go to the smaller index, whatever order the leaves are scanned in.
  friend bool operator<(const Neighbour& a, const Neighbour& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.index < b.index;
  }
  friend bool operator==(const Neighbour&, const Neighbour&) = default;
};

// Immutable, shareable between threads. Takes about 30 bytes a point.
class CodeTree {
 public:
  // `codes`: kDimensionMax per point, at least one point; not needed afterwards. A code of dimension j stands for
  // codes[j] * steps[j] grid units; steps are 0..kStepMax, and 0 for dimensions that are not used.
  CodeTree(std::span<const std::int8_t> codes, const Coordinates& steps);
  std::size_t size() const { return point_count_; }

 private:
  friend class CodeSearch;
  struct Leaf {
    std::uint32_t first_block = 0;  // of 16 points
    std::uint32_t point_count = 0;
  };
  void add_leaf(std::span<const std::int8_t> codes, std::span<const std::uint32_t> points);

  Coordinates steps_{};
  int dimension_count_ = 0;  // up to the last with a step
  std::size_t point_count_ = 0;
  std::vector<Leaf> leaves_;
  std::vector<std::int32_t> boxes_;   // blocks of 8 leaves
  std::vector<std::int8_t> blocks_;   // blocks of 16 points, each leaf beginning a block
  std::vector<std::int64_t> norms_;   // 16 a block
  std::vector<std::uint32_t> index_;  // 16 a block
};

// What one thread needs to search a tree, which must outlive it.
class CodeSearch {
 public:
  explicit CodeSearch(const CodeTree& tree, std::size_t count_max = kNeighbourMax);
  // The min(count, tree size) nearest, nearest first; count 1..count_max. Coordinates are clamped to
  // +-kCoordinateMax. The result is the caller's until the next call. No allocation.
  std::span<Neighbour> nearest(const Coordinates& query, std::size_t count);

 private:
  void scan(const CodeTree::Leaf& leaf, const CodeQuery& query, std::size_t count);
  void drop_far_ones(std::size_t count);
  std::span<Neighbour> sorted(std::size_t count);

  const CodeTree& tree_;
  std::size_t count_max_;
  std::vector<std::uint32_t> bounds_;
  std::vector<std::uint64_t> order_;  // bound, leaf
  std::vector<Neighbour> found_, sorted_;
  std::array<std::uint16_t, 1025> buckets_{};  // of distance
  std::size_t found_count_ = 0;
  std::int64_t reach_ = 0;  // points farther than this are none of the nearest
};

}  // namespace im2fit::index
