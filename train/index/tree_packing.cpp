// SPDX-License-Identifier: Apache-2.0
// nanoflann cuts the points into leaves; only its cuts are kept.
#include "train/index/tree_packing.h"

#include <algorithm>
#include <nanoflann.hpp>

namespace im2fit::index {
namespace {

struct CodeView {
  std::span<const std::int8_t> codes;
  const Coordinates& steps;
  std::size_t dimensions;
  std::size_t kdtree_get_point_count() const { return codes.size() / dimensions; }
  std::int32_t kdtree_get_pt(std::size_t i, std::size_t j) const { return codes[i * dimensions + j] * steps[j]; }
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

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<NoMetric, CodeView, -1, std::uint32_t>;

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

struct Edges {
  std::int16_t low, high;
};

// Boxes in blocks of 16; those that fill the last block are copies of the last box.
class BoxWriter {
 public:
  BoxWriter(std::size_t box_count, std::size_t dimensions)
      : values_(box_values(box_count, static_cast<int>(dimensions))), dimensions_(dimensions) {}
  void add(std::span<const Edges> box) {
    for (std::size_t i = count_; i < values_.size() / (2 * dimensions_); ++i)
      if (i == count_ || i / kBoxBlock == count_ / kBoxBlock) put(i, box);
    ++count_;
  }
  std::vector<std::int16_t> take() { return std::move(values_); }

 private:
  void put(std::size_t at, std::span<const Edges> box) {
    for (std::size_t d = 0; d < dimensions_; ++d) {
      std::int16_t* edge = values_.data() + (at / kBoxBlock * dimensions_ + d) * 2 * kBoxBlock + at % kBoxBlock;
      edge[0] = box[d].low;
      edge[kBoxBlock] = box[d].high;
    }
  }
  std::vector<std::int16_t> values_;
  std::size_t dimensions_;
  std::size_t count_ = 0;
};

}  // namespace

PackedTree pack_tree(std::span<const std::int8_t> codes, int dimension_count, const Coordinates& steps) {
  const auto dimensions = static_cast<std::size_t>(dimension_count);
  const CodeView view{codes, steps, dimensions};
  KdTree kd(dimension_count, view, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafMax));
  kd.buildIndex();

  PackedTree out;
  out.steps = steps;
  out.dimension_count = dimension_count;
  const std::size_t count = view.kdtree_get_point_count();
  out.order.reserve(count);
  for_each_leaf(kd, [&](std::span<const std::uint32_t> points) {
    out.leaf_first.push_back(static_cast<std::uint32_t>(out.order.size()));
    out.order.insert(out.order.end(), points.begin(), points.end());
  });
  const std::size_t leaves = out.leaf_first.size();
  out.leaf_first.push_back(static_cast<std::uint32_t>(count));

  out.blocks.resize(code_block_bytes(count, dimension_count));
  const std::size_t pairs = (dimensions + 1) / 2;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t d = 0; d < dimensions; ++d)
      out.blocks[(i / kCodeBlock * pairs + d / 2) * 2 * kCodeBlock + i % kCodeBlock * 2 + d % 2] =
          codes[out.order[i] * dimensions + d];

  BoxWriter leaf_boxes(leaves, dimensions), group_boxes((leaves + kGroupLeaves - 1) / kGroupLeaves, dimensions);
  std::vector<Edges> box(dimensions), group(dimensions);
  for (std::size_t l = 0; l < leaves; ++l) {
    for (std::size_t d = 0; d < dimensions; ++d) {
      int low = 127, high = -128;
      for (std::size_t i = out.leaf_first[l]; i < out.leaf_first[l + 1]; ++i) {
        const int c = codes[out.order[i] * dimensions + d];
        low = std::min(low, c);
        high = std::max(high, c);
      }
      box[d] = {static_cast<std::int16_t>(low * steps[d]), static_cast<std::int16_t>(high * steps[d])};
      if (l % kGroupLeaves == 0) group[d] = box[d];
      group[d] = {std::min(group[d].low, box[d].low), std::max(group[d].high, box[d].high)};
    }
    leaf_boxes.add(box);
    if (l % kGroupLeaves == kGroupLeaves - 1 || l + 1 == leaves) group_boxes.add(group);
  }
  out.leaf_boxes = leaf_boxes.take();
  out.group_boxes = group_boxes.take();
  return out;
}

CodeTree PackedTree::view() const {
  return {order.size(), dimension_count, steps, blocks, {}, leaf_first, leaf_boxes, group_boxes};
}

}  // namespace im2fit::index
