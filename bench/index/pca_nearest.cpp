// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <nanoflann.hpp>

#include "bench/index/plain_pca.h"

namespace im2fit::bench {
namespace {

constexpr std::size_t kLeafSize = 16;

struct Rows {
  std::vector<float> values;
  std::size_t kdtree_get_point_count() const { return values.size() / kPcaSize; }
  float kdtree_get_pt(std::size_t point, std::size_t dimension) const { return values[point * kPcaSize + dimension]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Rows>, Rows,
                                                   static_cast<int>(kPcaSize), std::uint32_t>;

}  // namespace

struct PcaNearest::Tree {
  Rows rows;
  std::unique_ptr<KdTree> tree;
  std::vector<std::uint32_t> found;
  std::vector<float> distance;
};

void PlainPca::project(std::span<const float> feature, std::span<float> out) const {
  const std::size_t size = mean_.size();
  std::vector<float> centred(size);
  for (std::size_t i = 0; i < size; ++i) centred[i] = feature[i] - mean_[i];
  for (std::size_t d = 0; d < out.size(); ++d) {
    float sum = 0;
    for (std::size_t i = 0; i < size; ++i) sum += centred[i] * axes_[d * size + i];
    out[d] = sum;
  }
}

PcaNearest::PcaNearest(PlainPca pca) : pca_(std::move(pca)), tree_(std::make_unique<Tree>()) {}
PcaNearest::~PcaNearest() = default;

void PcaNearest::add(std::span<const float> feature) {
  auto& values = tree_->rows.values;
  values.resize(values.size() + kPcaSize);
  pca_.project(feature, std::span(values).last(kPcaSize));
}

void PcaNearest::build() {
  tree_->tree = std::make_unique<KdTree>(static_cast<int>(kPcaSize), tree_->rows,
                                         nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
}

std::size_t PcaNearest::size() const {
  return tree_->rows.kdtree_get_point_count();
}

std::span<const std::uint32_t> PcaNearest::nearest(std::span<const float> feature, std::size_t count) {
  std::array<float, kPcaSize> query{};
  pca_.project(feature, query);
  tree_->found.resize(count);
  tree_->distance.resize(count);
  const std::size_t found = tree_->tree->knnSearch(query.data(), count, tree_->found.data(), tree_->distance.data());
  return std::span(tree_->found).first(found);
}

std::uint32_t PcaNearest::nearest_exhaustive(std::span<const float> feature) const {
  std::array<float, kPcaSize> query{};
  pca_.project(feature, query);
  std::uint32_t best = 0;
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t n = 0; n < size(); ++n) {
    float sum = 0;
    for (std::size_t d = 0; d < kPcaSize; ++d) {
      const float difference = query[d] - tree_->rows.values[n * kPcaSize + d];
      sum += difference * difference;
    }
    if (sum >= least) continue;
    least = sum;
    best = static_cast<std::uint32_t>(n);
  }
  return best;
}

std::size_t PcaNearest::bytes() const {
  return pca_.bytes() + 4 * tree_->rows.values.size() + tree_->tree->usedMemory(*tree_->tree);
}

}  // namespace im2fit::bench
