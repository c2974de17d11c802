// SPDX-License-Identifier: Apache-2.0
#include "index/code_tree.h"

#include <algorithm>
#include <limits>

namespace im2fit::index {
namespace {

// Fewer points are scanned: bounding boxes would not pay.
constexpr std::size_t kScanMax = 1024;
constexpr std::size_t kChunk = 256;  // points whose distances lie on the stack

constexpr std::uint64_t key_of(std::int32_t distance, std::size_t index) {
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(distance)) << 32 | static_cast<std::uint32_t>(index);
}
constexpr std::int32_t distance_of(std::uint64_t key) {
  return static_cast<std::int32_t>(key >> 32);
}
constexpr std::size_t index_of(std::uint64_t key) {
  return key & 0xFFFFFFFFU;
}

std::size_t blocks_of(std::size_t count, std::size_t unit) {
  return (count + unit - 1) / unit;
}

}  // namespace

std::size_t code_block_bytes(std::size_t point_count, int dimension_count) {
  return blocks_of(point_count, kCodeBlock) * kCodeBlock * 2 * static_cast<std::size_t>((dimension_count + 1) / 2);
}

std::size_t box_values(std::size_t box_count, int dimension_count) {
  return blocks_of(box_count, kBoxBlock) * kBoxBlock * 2 * static_cast<std::size_t>(dimension_count);
}

CodeSearch::CodeSearch(const CodeTree& tree, std::size_t count_max)
    : tree_(tree),
      count_max_(count_max),
      group_bounds_(blocks_of(tree.group_count(), kBoxBlock) * kBoxBlock),
      groups_(tree.group_count()),
      found_(count_max),
      result_(count_max) {}

std::span<Neighbour> CodeSearch::nearest(const Coordinates& query, std::size_t count) {
  if (tree_.point_count <= kScanMax) return exhaustive(query, count);
  begin(count);
  const CodeQuery prepared(tree_.steps.data(), query.data(), tree_.dimension_count);
  code_bounds(tree_.group_boxes.data(), static_cast<int>(group_bounds_.size() / kBoxBlock), prepared.place.data(),
              tree_.dimension_count, group_bounds_.data());
  // The nearest group gives a reach that most of the others are beyond.
  const auto bounds = std::span(group_bounds_).first(tree_.group_count());
  const auto first = static_cast<std::size_t>(std::min_element(bounds.begin(), bounds.end()) - bounds.begin());
  search_group(first, prepared);
  std::size_t ahead = 0;
  for (std::size_t g = 0; g < bounds.size(); ++g)
    if (g != first && bounds[g] <= reach_) groups_[ahead++] = key_of(bounds[g], g);
  const auto others = std::span(groups_).first(ahead);
  std::sort(others.begin(), others.end());
  for (const Key group : others) {
    if (distance_of(group) > reach_) break;
    search_group(index_of(group), prepared);
  }
  return finish();
}

std::span<Neighbour> CodeSearch::exhaustive(const Coordinates& query, std::size_t count) {
  begin(count);
  scan(0, tree_.point_count, CodeQuery(tree_.steps.data(), query.data(), tree_.dimension_count));
  return finish();
}

void CodeSearch::begin(std::size_t count) {
  count_ = std::clamp<std::size_t>(count, 1, std::min(count_max_, tree_.point_count));
  found_count_ = 0;
  reach_ = std::numeric_limits<std::int32_t>::max();
  damaged_ = {};
  work_ = {};
}

void CodeSearch::search_group(std::size_t group, const CodeQuery& query) {
  ++work_.groups;
  const std::size_t first = group * kGroupLeaves;
  const std::size_t leaves = std::min(kGroupLeaves, tree_.leaf_count() - first);
  const auto dimensions = static_cast<std::size_t>(tree_.dimension_count);
  std::int32_t bounds[kGroupLeaves];
  code_bounds(tree_.leaf_boxes.data() + first * 2 * dimensions, static_cast<int>(blocks_of(leaves, kBoxBlock)),
              query.place.data(), tree_.dimension_count, bounds);
  Key ahead[kGroupLeaves];
  Key* end = ahead;
  for (std::size_t l = 0; l < leaves; ++l)
    if (bounds[l] <= reach_) *end++ = key_of(bounds[l], first + l);
  std::sort(ahead, end);
  for (const Key* leaf = ahead; leaf != end && distance_of(*leaf) <= reach_; ++leaf) {
    ++work_.leaves;
    scan(tree_.leaf_first[index_of(*leaf)], tree_.leaf_first[index_of(*leaf) + 1], query);
  }
}

void CodeSearch::scan(std::size_t first, std::size_t last, const CodeQuery& query) {
  work_.points += last - first;
  const std::size_t block_bytes = tree_.pair_count() * 2 * kCodeBlock;
  while (first < last) {
    // Leaves do not begin with a block: the points before and behind are passed over.
    const std::size_t block = first / kCodeBlock, base = block * kCodeBlock;
    const std::size_t end = std::min(last, base + kChunk);
    const ByteRange read{block * block_bytes, blocks_of(end - base, kCodeBlock) * block_bytes};
    if (!tree_.pages.intact(read)) {
      damaged_ = read;
      reach_ = -1;  // ends the search: nothing is as near as that
      return;
    }
    std::int32_t distance[kChunk], least[kChunk / kCodeBlock];
    code_distance(tree_.blocks.data() + block * block_bytes, static_cast<int>(blocks_of(end - base, kCodeBlock)),
                  query, distance, least);
    // Few points are near enough: most blocks are done once their nearest is compared.
    for (std::size_t at = base; at < end; at += kCodeBlock) {
      if (least[(at - base) / kCodeBlock] > reach_) continue;
      const std::size_t stop = std::min(end, at + kCodeBlock);
      for (std::size_t i = std::max(first, at); i < stop; ++i)
        if (distance[i - base] <= reach_) offer(key_of(distance[i - base], i));
    }
    first = end;
  }
}

// The nearest so far are a heap, farthest on top.
void CodeSearch::offer(Key key) {
  if (found_count_ < count_) {
    found_[found_count_++] = key;
    if (found_count_ < count_) return;
    std::make_heap(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(count_));
  } else if (key < found_[0]) {
    std::size_t hole = 0;
    for (std::size_t child = 1; child < count_; child = 2 * hole + 1) {
      child += child + 1 < count_ && found_[child + 1] > found_[child] ? 1 : 0;
      if (found_[child] <= key) break;
      found_[hole] = found_[child];
      hole = child;
    }
    found_[hole] = key;
  }
  reach_ = distance_of(found_[0]);
}

std::span<Neighbour> CodeSearch::finish() {
  const auto found = std::span(found_).first(found_count_);
  std::sort(found.begin(), found.end());
  for (std::size_t i = 0; i < found.size(); ++i)
    result_[i] = {distance_of(found[i]), static_cast<std::uint32_t>(index_of(found[i]))};
  return std::span(result_).first(found.size());
}

}  // namespace im2fit::index
