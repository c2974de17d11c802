// SPDX-License-Identifier: Apache-2.0
// The walk every tier shares: a chain of dependent loads, five deep. Vectors do not help (a gather costs what its
// loads cost), company does: four trees are walked side by side so that their chains overlap.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/joints/trees/trees.h"

namespace im2fit::joints {
namespace {

constexpr int kBatch = 16;  // trees whose leaves are on their way from memory before the first is added
constexpr int kLeafValues = kLeafCount * kLeafSize;

// A model is larger than the caches of a tablet: a leaf's 32 bytes are asked for as soon as they are known.
inline const std::int8_t* asked_for(const std::int8_t* leaf) {
  __builtin_prefetch(leaf);
  return leaf;
}

inline int next_node(const Split* tree, const std::int16_t* pixels, int node) {
  const Split& s = tree[node];
  return 2 * node + 1 + (pixels[s.a] - pixels[s.b] > s.threshold ? 1 : 0);
}

// Leaves of `count` <= kBatch trees.
inline void find_leaves(const Split* splits, const std::int8_t* leaves, int count, const std::int16_t* pixels,
                        const std::int8_t** found) {
  int t = 0;
  for (; t + 4 <= count; t += 4) {
    const Split* tree = splits + std::ptrdiff_t{t} * kSplitCount;
    int a = 0, b = 0, c = 0, d = 0;
    for (int depth = 0; depth < kSplitDepth; ++depth) {
      a = next_node(tree, pixels, a);
      b = next_node(tree + kSplitCount, pixels, b);
      c = next_node(tree + 2 * kSplitCount, pixels, c);
      d = next_node(tree + 3 * kSplitCount, pixels, d);
    }
    const std::int8_t* leaf = leaves + std::ptrdiff_t{t} * kLeafValues - kSplitCount * kLeafSize;
    found[t] = asked_for(leaf + a * kLeafSize);
    found[t + 1] = asked_for(leaf + kLeafValues + b * kLeafSize);
    found[t + 2] = asked_for(leaf + 2 * kLeafValues + c * kLeafSize);
    found[t + 3] = asked_for(leaf + 3 * kLeafValues + d * kLeafSize);
  }
  for (; t < count; ++t) {
    int a = 0;
    for (int depth = 0; depth < kSplitDepth; ++depth)
      a = next_node(splits + std::ptrdiff_t{t} * kSplitCount, pixels, a);
    found[t] = asked_for(leaves + std::ptrdiff_t{t} * kLeafValues + (a - kSplitCount) * kLeafSize);
  }
}

// Calls add(leaves, count) for every batch, one batch behind the walk.
template <class Add>
inline void for_each_batch(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                           Add add) {
  const std::int8_t* found[2][kBatch];
  int before = 0, turn = 0;
  for (int t = 0; t < tree_count; t += kBatch, turn ^= 1) {
    const int count = tree_count - t < kBatch ? tree_count - t : kBatch;
    find_leaves(splits + std::ptrdiff_t{t} * kSplitCount, leaves + std::ptrdiff_t{t} * kLeafValues, count, pixels,
                found[turn]);
    add(found[turn ^ 1], before);
    before = count;
  }
  add(found[turn ^ 1], before);
}

}  // namespace
}  // namespace im2fit::joints
