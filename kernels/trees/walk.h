// SPDX-License-Identifier: Apache-2.0
// The walk every tier shares. Down one path it would be a chain of dependent loads, five deep, that vectors do not
// help. All runs stand before the same tree, though: every split is answered for all of them at once, and the answers
// are merged from the leaves up. That is six times the comparisons, in vectors of eight, and no chain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "kernels/trees/trees.h"

namespace im2fit::joints {
namespace {

constexpr int kBatch = 16;  // trees whose leaves are on their way from memory before the first is added
constexpr int kLeafValues = kLeafCount * kLeafSize;

using Lanes = std::int16_t __attribute__((vector_size(2 * kRunLanes)));

inline Lanes lanes_of(const std::int16_t* p) {
  Lanes out;
  std::memcpy(&out, p, sizeof out);
  return out;
}

// By run, the leaf's place among those under `kNode`, the root of a tree of `kDepth`.
template <int kNode, int kDepth>
inline Lanes leaf_under(const Split* tree, const std::int16_t* pixels) {
  const Split& s = tree[kNode];
  const Lanes limit = Lanes{} + s.threshold;
  const Lanes right = lanes_of(pixels + s.a * kRunLanes) - lanes_of(pixels + s.b * kRunLanes) > limit;  // 0 or -1
  constexpr std::int16_t kHere = 1 << (kDepth - 1);
  if constexpr (kDepth == 1) {
    return right & kHere;
  } else {
    const Lanes a = leaf_under<2 * kNode + 1, kDepth - 1>(tree, pixels);
    const Lanes b = leaf_under<2 * kNode + 2, kDepth - 1>(tree, pixels);
    return (right & kHere) | (b & right) | (a & ~right);
  }
}

// Some trees' leaves: of run r and tree t at leaves + t * kLeafValues + at[t][r].
struct LeafBatch {
  const std::int8_t* leaves = nullptr;
  int count = 0;
  std::int16_t at[kBatch][kRunLanes];
  const std::int8_t* leaf(int tree, int run) const {
    return leaves + std::ptrdiff_t{tree} * kLeafValues + at[tree][run];
  }
};

// A model is larger than the caches of a tablet: a leaf's 32 bytes are prefetched as soon as they are known.
inline void find_leaves(const Split* splits, const std::int16_t* pixels, int run_count, LeafBatch& batch) {
  for (int t = 0; t < batch.count; ++t) {
    const Lanes at = leaf_under<0, kSplitDepth>(splits + std::ptrdiff_t{t} * kSplitCount, pixels) *
                     static_cast<std::int16_t>(kLeafSize);
    std::memcpy(batch.at[t], &at, sizeof at);
    for (int r = 0; r < run_count; ++r) __builtin_prefetch(batch.leaf(t, r));
  }
}

// Calls add(batch) for every batch, one batch behind the walk.
template <class Add>
inline void for_each_batch(const Split* splits, const std::int8_t* leaves, int tree_count, const std::int16_t* pixels,
                           int run_count, Add add) {
  LeafBatch batches[2];
  int turn = 0;
  for (int t = 0; t < tree_count; t += kBatch, turn ^= 1) {
    LeafBatch& batch = batches[turn];
    batch.leaves = leaves + std::ptrdiff_t{t} * kLeafValues;
    batch.count = tree_count - t < kBatch ? tree_count - t : kBatch;
    find_leaves(splits + std::ptrdiff_t{t} * kSplitCount, pixels, run_count, batch);
    add(batches[turn ^ 1]);
  }
  add(batches[turn ^ 1]);
}

}  // namespace
}  // namespace im2fit::joints
