// SPDX-License-Identifier: Apache-2.0
// Exact nearest neighbours among int8 codes, by nanoflann's kd-tree over the caller's bytes (no copy).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

namespace im2fit::index {

inline constexpr int kDimensionMax = 16;  // codes are padded to this with zeros
inline constexpr int kNeighbourMax = 512;
inline constexpr int kStepMax = 1024;  // of one code, in units of the common grid
// Bound of a query coordinate: the largest code reaches 128 * 1024 = 2^17, so a squared distance stays below
// 16 * (2^20 + 2^17)^2 < 2^45: exact in int64 and in double.
inline constexpr std::int32_t kCoordinateMax = 1 << 20;

using Coordinates = std::array<std::int32_t, kDimensionMax>;

struct Neighbour {
  std::int64_t distance = 0;  // squared, in units of the common grid
  std::uint32_t index = 0;
  // Ties go to the smaller index, whatever order the tree is walked in.
  friend bool operator<(const Neighbour& a, const Neighbour& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.index < b.index;
  }
  friend bool operator==(const Neighbour&, const Neighbour&) = default;
};

class CodeTree {
 public:
  // `codes`: kDimensionMax per point, at least one point; must outlive the tree. A code of dimension j stands for
  // codes[j] * steps[j] grid units; steps are 0..kStepMax.
  CodeTree(std::span<const std::int8_t> codes, const Coordinates& steps);
  CodeTree(CodeTree&&) noexcept;
  CodeTree& operator=(CodeTree&&) noexcept;
  ~CodeTree();

  std::size_t size() const;
  // The min(out.size(), size()) nearest, nearest first. No allocation; may be called from several threads.
  std::span<Neighbour> nearest(const Coordinates& query, std::span<Neighbour> out) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace im2fit::index
