// SPDX-License-Identifier: Apache-2.0
// The baseline: principal components of the raw features, knowing nothing of noise or bodies, and the nearest by them
// with nanoflann's own tree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace im2fit::bench {

class PlainPca {
 public:
  // `rows` of `size` values each. The directions of most variance, most first; the solver chooses their signs.
  static PlainPca fit(std::span<const float> rows, std::size_t size, std::size_t dimensions);
  std::size_t dimensions() const { return axes_.size() / mean_.size(); }
  double explained() const { return explained_; }  // share of the variance, 0..1
  void project(std::span<const float> feature, std::span<float> out) const;
  std::size_t bytes() const { return 4 * (mean_.size() + axes_.size()); }

 private:
  std::vector<float> mean_, axes_;
  double explained_ = 0;
};

inline constexpr std::size_t kPcaSize = 16;

class PcaNearest {
 public:
  explicit PcaNearest(PlainPca pca);  // of kPcaSize dimensions
  ~PcaNearest();
  void add(std::span<const float> feature);
  void build();  // once, after the last
  std::size_t size() const;
  // The min(count, size()) nearest, nearest first. Valid until the next call.
  std::span<const std::uint32_t> nearest(std::span<const float> feature, std::size_t count);
  std::uint32_t nearest_exhaustive(std::span<const float> feature) const;
  std::size_t bytes() const;

 private:
  struct Tree;
  PlainPca pca_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace im2fit::bench
