// SPDX-License-Identifier: Apache-2.0
#include "index/code_tree.h"

#include <algorithm>
#include <limits>
#include <nanoflann.hpp>

#include "kernels/code_bounds/code_bounds.h"

namespace im2fit::index {
namespace {

constexpr std::size_t kLeafSize = 64;  // points: large enough for whole blocks, small enough for tight boxes

struct CodeView {
  std::span<const std::int8_t> codes;
  Coordinates steps{};
  std::size_t kdtree_get_point_count() const { return codes.size() / kDimensionMax; }
  std::int32_t kdtree_get_pt(std::size_t i, std::size_t j) const { return codes[i * kDimensionMax + j] * steps[j]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

// nanoflann wants a metric; only its tree is used.
struct NoMetric {
  using ElementType = std::int32_t;
  using DistanceType = double;
  explicit NoMetric(const CodeView&) {}
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<NoMetric, CodeView, kDimensionMax, std::uint32_t>;

// Calls leaf(points) for every leaf, left to right.
template <class Leaf>
void for_each_leaf(const KdTree& tree, Leaf leaf) {
#if NANOFLANN_VERSION >= 0x150
  const std::span<const std::uint32_t> points(tree.vAcc_);
  const auto* node = tree.root_node_;
#else
  const std::span<const std::uint32_t> points(tree.vAcc);
  const auto* node = tree.root_node;
#endif
  std::vector<decltype(node)> ahead = {node};
  while (!ahead.empty()) {
    node = ahead.back();
    ahead.pop_back();
    if (node->child1 == nullptr) {
      const auto& range = node->node_type.lr;
      leaf(points.subspan(range.left, range.right - range.left));
    } else {
      ahead.push_back(node->child2);
      ahead.push_back(node->child1);
    }
  }
}

// distance >> shift is below kBucketCount for all.
constexpr std::int64_t kBucketCount = 1024;
int bucket_shift(std::span<const Neighbour> found) {
  std::int64_t farthest = 0;
  for (const Neighbour& n : found) farthest = std::max(farthest, n.distance);
  int shift = 0;
  while (farthest >> shift >= kBucketCount) ++shift;
  return shift;
}

std::size_t rounded_up(std::size_t n, std::size_t unit) {
  return (n + unit - 1) / unit * unit;
}

}  // namespace

CodeTree::CodeTree(std::span<const std::int8_t> codes, const Coordinates& steps)
    : steps_(steps), point_count_(codes.size() / kDimensionMax) {
  for (int d = 0; d < kDimensionMax; ++d)
    if (steps[static_cast<std::size_t>(d)] != 0) dimension_count_ = d + 1;
  const CodeView view{codes, steps};
  KdTree kd(kDimensionMax, view, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
  kd.buildIndex();
  for_each_leaf(kd, [&](std::span<const std::uint32_t> points) { add_leaf(codes, points); });
}

void CodeTree::add_leaf(std::span<const std::int8_t> codes, std::span<const std::uint32_t> points) {
  const auto dimensions = static_cast<std::size_t>(dimension_count_);
  const auto code_of = [&](std::uint32_t point, std::size_t d) -> std::int32_t {
    return codes[std::size_t{point} * kDimensionMax + d];
  };
  const std::size_t pairs = (dimensions + 1) / 2;
  const std::size_t first_block = index_.size() / kCodeBlock;
  const std::size_t padded = rounded_up(points.size(), kCodeBlock);
  index_.resize(index_.size() + padded);
  norms_.resize(norms_.size() + padded);
  blocks_.resize(blocks_.size() + padded * 2 * pairs);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t place = first_block * kCodeBlock + i;
    std::int8_t* block = blocks_.data() + place / kCodeBlock * kCodeBlock * 2 * pairs;
    index_[place] = points[i];
    for (std::size_t d = 0; d < dimensions; ++d) {
      const std::int64_t at = std::int64_t{code_of(points[i], d)} * steps_[d];
      norms_[place] += at * at;
      block[(d / 2 * kCodeBlock + place % kCodeBlock) * 2 + d % 2] =
          codes[std::size_t{points[i]} * kDimensionMax + d];
    }
  }

  const std::size_t leaf = leaves_.size();
  leaves_.push_back({static_cast<std::uint32_t>(first_block), static_cast<std::uint32_t>(points.size())});
  boxes_.resize(rounded_up(leaves_.size(), kBoxBlock) * 2 * dimensions);
  for (std::size_t d = 0; d < dimensions; ++d) {
    std::int32_t low = code_of(points[0], d), high = low;
    for (const std::uint32_t p : points) {
      low = std::min(low, code_of(p, d));
      high = std::max(high, code_of(p, d));
    }
    std::int32_t* box = boxes_.data() + (leaf / kBoxBlock * dimensions + d) * 2 * kBoxBlock + leaf % kBoxBlock;
    box[0] = low * steps_[d];
    box[kBoxBlock] = high * steps_[d];
  }
}

CodeSearch::CodeSearch(const CodeTree& tree, std::size_t count_max)
    : tree_(tree),
      count_max_(count_max),
      bounds_(rounded_up(tree.leaves_.size(), kBoxBlock)),
      order_(tree.leaves_.size()),
      found_(2 * count_max + kLeafSize),
      sorted_(found_.size()) {}

std::span<Neighbour> CodeSearch::nearest(const Coordinates& query, std::size_t count) {
  count = std::clamp<std::size_t>(count, 1, std::min(count_max_, tree_.size()));
  CodeQuery prepared(tree_.steps_.data(), query.data(), tree_.dimension_count_);
  // Every point is at 0 in a dimension without a step.
  for (auto d = static_cast<std::size_t>(tree_.dimension_count_); d < query.size(); ++d) {
    const std::int64_t far = std::clamp(query[d], -kCoordinateMax, kCoordinateMax);
    prepared.square += far * far;
  }
  code_bounds(tree_.boxes_.data(), static_cast<int>(bounds_.size() / kBoxBlock), prepared.place.data(),
              tree_.dimension_count_, bounds_.data());
  for (std::size_t l = 0; l < order_.size(); ++l) order_[l] = std::uint64_t{bounds_[l]} << 32 | l;

  // The nearest boxes give a reach that most of the others are beyond.
  const std::size_t first = std::min(order_.size(), 1 + 2 * count / kLeafSize);
  std::nth_element(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(first - 1), order_.end());
  found_count_ = 0;
  reach_ = std::numeric_limits<std::int64_t>::max();
  for (std::size_t i = 0; i < order_.size(); ++i) {
    if (i == first) drop_far_ones(count);
    if (static_cast<std::int64_t>(order_[i] >> 32) << kBoundUnitBits > reach_) continue;
    scan(tree_.leaves_[order_[i] & 0xFFFFFFFFU], prepared, count);
  }
  return sorted(count);
}

void CodeSearch::scan(const CodeTree::Leaf& leaf, const CodeQuery& query, std::size_t count) {
  std::int64_t distance[kLeafSize];
  const auto pairs = static_cast<std::size_t>(query.pair_count);
  const std::size_t first = std::size_t{leaf.first_block} * kCodeBlock;
  // nanoflann never makes a leaf larger than it was told to.
  const std::size_t points = std::min<std::size_t>(leaf.point_count, kLeafSize);
  code_distance(tree_.blocks_.data() + first * 2 * pairs, tree_.norms_.data() + first,
                static_cast<int>(rounded_up(points, kCodeBlock) / kCodeBlock), query, distance);
  if (found_count_ + points > found_.size()) drop_far_ones(count);
  Neighbour* end = found_.data() + found_count_;
  for (std::size_t i = 0; i < points; ++i) {
    *end = {distance[i], tree_.index_[first + i]};
    end += distance[i] <= reach_ ? 1 : 0;
  }
  found_count_ = static_cast<std::size_t>(end - found_.data());
  // With one neighbour wanted every leaf draws the reach in.
  if (count <= 4) drop_far_ones(count);
}

// Keeps at least the `count` nearest: all that lie in the buckets of distance that hold them.
void CodeSearch::drop_far_ones(std::size_t count) {
  if (found_count_ <= count) {
    if (found_count_ == count)
      for (reach_ = 0; const Neighbour& n : std::span(found_).first(count)) reach_ = std::max(reach_, n.distance);
    return;
  }
  const auto found = std::span(found_).first(found_count_);
  if (count <= 4) {
    std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count - 1), found.end());
    found_count_ = count;
    reach_ = found_[count - 1].distance;
    return;
  }
  const int shift = bucket_shift(found);
  buckets_.fill(0);
  for (const Neighbour& n : found) ++buckets_[static_cast<std::size_t>(n.distance >> shift)];
  std::size_t last = 0, held = buckets_[0];
  while (held < count) held += buckets_[++last];
  reach_ = (static_cast<std::int64_t>(last + 1) << shift) - 1;
  Neighbour* end = found_.data();
  for (const Neighbour n : found) {
    *end = n;
    end += n.distance <= reach_ ? 1 : 0;
  }
  found_count_ = static_cast<std::size_t>(end - found_.data());
  if (found_count_ + kLeafSize <= found_.size()) return;
  // Hundreds at one distance: the order by index decides.
  const auto rest = std::span(found_).first(found_count_);
  std::nth_element(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(count - 1), rest.end());
  found_count_ = count;
  reach_ = found_[count - 1].distance;
}

// By distance into buckets, then by insertion: the distances lie close together near the farthest, so that buckets
// hold one or two.
std::span<Neighbour> CodeSearch::sorted(std::size_t count) {
  drop_far_ones(count);
  const auto found = std::span(found_).first(found_count_);
  const int shift = bucket_shift(found);
  buckets_.fill(0);
  for (const Neighbour& n : found) ++buckets_[static_cast<std::size_t>(n.distance >> shift) + 1];
  for (std::size_t b = 1; b < buckets_.size(); ++b)
    buckets_[b] = static_cast<std::uint16_t>(buckets_[b] + buckets_[b - 1]);
  for (const Neighbour& n : found) sorted_[buckets_[static_cast<std::size_t>(n.distance >> shift)]++] = n;
  for (std::size_t i = 1; i < found_count_; ++i) {
    const Neighbour n = sorted_[i];
    std::size_t j = i;
    for (; j > 0 && n < sorted_[j - 1]; --j) sorted_[j] = sorted_[j - 1];
    sorted_[j] = n;
  }
  return std::span(sorted_).first(count);
}

}  // namespace im2fit::index
