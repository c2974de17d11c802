// SPDX-License-Identifier: Apache-2.0
#include "index/code_tree.h"

#include <algorithm>
#include <nanoflann.hpp>

namespace im2fit::index {
namespace {

constexpr std::size_t kLeafSize = 24;  // points; a leaf of int8 codes is a few cache lines

// The k smallest by (distance, index): a max-heap in the caller's memory.
class HeapResult {
 public:
  using DistanceType = double;
  explicit HeapResult(std::span<Neighbour> out) : out_(out) {}
  std::size_t size() const { return count_; }
  bool full() const { return count_ == out_.size(); }
  bool addPoint(double distance, std::uint32_t index) {
    const Neighbour candidate{static_cast<std::int64_t>(distance), index};
    const auto begin = out_.begin();
    if (!full()) {
      out_[count_++] = candidate;
      std::push_heap(begin, begin + static_cast<std::ptrdiff_t>(count_));
    } else if (candidate < out_.front()) {
      std::pop_heap(begin, out_.end());
      out_.back() = candidate;
      std::push_heap(begin, out_.end());
    }
    return true;
  }
  // nanoflann keeps points with distance < worstDist(); distances are whole numbers, so + 0.5 lets ties through and
  // the answer does not depend on the order of the walk, nor on nanoflann's version.
  double worstDist() const { return full() ? static_cast<double>(out_.front().distance) + 0.5 : 1e300; }
  std::span<Neighbour> sorted() {
    const auto found = out_.first(count_);
    std::sort_heap(found.begin(), found.end());
    return found;
  }

 private:
  std::span<Neighbour> out_;
  std::size_t count_ = 0;
};

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

// Squared Euclidean distance of whole numbers. double carries them exactly (kCoordinateMax).
struct GridMetric {
  using ElementType = std::int32_t;
  using DistanceType = double;
  const CodeView& view;
  explicit GridMetric(const CodeView& v) : view(v) {}
  double evalMetric(const std::int32_t* a, std::uint32_t index, std::size_t size) const {
    const std::int8_t* b = view.codes.data() + static_cast<std::size_t>(index) * kDimensionMax;
    std::int64_t sum = 0;
    for (std::size_t j = 0; j < size; ++j) {
      const std::int64_t d = a[j] - b[j] * view.steps[j];
      sum += d * d;
    }
    return static_cast<double>(sum);
  }
  template <class U, class V>
  double accum_dist(const U a, const V b, std::size_t) const {
    const double d = static_cast<double>(a) - static_cast<double>(b);
    return d * d;
  }
};

}  // namespace

struct CodeTree::Tree {
  CodeView view;
  nanoflann::KDTreeSingleIndexAdaptor<GridMetric, CodeView, kDimensionMax, std::uint32_t> kd;
  Tree(std::span<const std::int8_t> codes, const Coordinates& steps)
      : view{codes, steps}, kd(kDimensionMax, view, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {
    kd.buildIndex();
  }
};

CodeTree::CodeTree(std::span<const std::int8_t> codes, const Coordinates& steps)
    : tree_(std::make_unique<Tree>(codes, steps)) {}
CodeTree::CodeTree(CodeTree&&) noexcept = default;
CodeTree& CodeTree::operator=(CodeTree&&) noexcept = default;
CodeTree::~CodeTree() = default;

std::size_t CodeTree::size() const {
  return tree_->view.kdtree_get_point_count();
}

std::span<Neighbour> CodeTree::nearest(const Coordinates& query, std::span<Neighbour> out) const {
  if (out.empty()) return out;
  Coordinates bounded = query;
  for (auto& c : bounded) c = std::clamp(c, -kCoordinateMax, kCoordinateMax);
  HeapResult result(out);
  tree_->kd.findNeighbors(result, bounded.data(), nanoflann::SearchParams());
  return result.sorted();
}

}  // namespace im2fit::index
