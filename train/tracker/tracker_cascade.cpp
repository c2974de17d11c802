// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_cascade.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/rng.h"
#include "train/common/linear_algebra.h"
#include "train/common/parallel.h"
#include "train/common/simd_clones.h"

namespace im2fit::lab {
namespace {

using joints::Anchor;
using joints::Basis;
using joints::kLeafCount;
using joints::kLeafSize;
using joints::kShapeSize;
using joints::kSplitCount;
using joints::Split;

constexpr std::uint64_t kAnchorStream = 0x616E6368;
constexpr std::uint64_t kLevelStream = 0x6C65766C;
constexpr int kBatchTreeCount = 8;  // trees that learn on the same residuals; any thread count gives the same
constexpr int kCandidateCount = 90;
constexpr int kExaminedMax = 1200;
constexpr std::size_t kScoreSize = 6;  // two joints' residuals judge a split
using Score = std::array<float, 8>;    // them, a count, and what makes it whole vectors
constexpr double kShrinkage = 0.11;
constexpr double kLeafPrior = 12;      // samples' worth of "no correction" in every leaf
constexpr double kBetweenShare = 0.6;  // of the anchors lie between two joints, and nearer to that line:
constexpr double kBetweenSpread = 0.5;
constexpr double kPairReachMm = 450;  // near pairs are likelier (Kazemi 2014, section 2.3.2)
constexpr double kLeafReach = 5;      // standard deviations of the residual that a leaf can hold
constexpr double kUnitMinMm = 1e-3;

using Sums = std::array<std::int32_t, static_cast<std::size_t>(kLeafSize)>;

// A shape's coefficients, filled up with zeros to whole vectors.
constexpr std::size_t kWideSize = 48;
static_assert(kWideSize >= static_cast<std::size_t>(kShapeSize));
using Wide = std::array<float, kWideSize>;
using WideSum = std::array<double, kWideSize>;
using WideBasis = std::array<Wide, static_cast<std::size_t>(kLeafSize)>;

struct Level {
  std::span<const Anchor> anchors;
  Basis basis{};
  std::array<std::array<float, static_cast<std::size_t>(kShapeSize)>, static_cast<std::size_t>(kLeafSize)> units{};
  std::vector<Sums> sums;                         // by start: the sum of the level's trees
  std::array<double, kJointCount> joint_share{};  // of the residual's spread
  std::vector<std::array<float, 2>> where;        // anchors about the mean shape, mm
  std::vector<std::int16_t> pixels;               // starts * pixel_count: judging splits reads a start's
  std::vector<std::int16_t> columns;              // pixel_count * starts: splitting reads a pixel of all starts
  std::vector<Wide> residual;                     // by start
  int pixel_count = 0;
  const std::int16_t* row(std::int32_t start) const {
    return pixels.data() + static_cast<std::size_t>(start) * static_cast<std::size_t>(pixel_count);
  }
  const std::int16_t* column(std::size_t pixel) const { return columns.data() + pixel * residual.size(); }
  const Wide& left_to_go(std::int32_t start) const { return residual[static_cast<std::size_t>(start)]; }
};

struct Tree {
  std::array<Split, kSplitCount> splits{};
  std::vector<std::int8_t> leaves = std::vector<std::int8_t>(static_cast<std::size_t>(kLeafCount * kLeafSize));
  std::vector<std::uint8_t> leaf_of;  // by start
};

// Adds a start's score to each candidate that sends it to the high side. `row`: the start's pixels. Vectors by hand,
// of a score's eight numbers: the vectoriser would take sixteen candidates at once, and spend its time on putting
// them in order.
IM2FIT_SIMD_CLONES void add_to_high(const std::array<Split, kCandidateCount>& candidates, const std::int16_t* row,
                                    const Score& score, std::array<Score, kCandidateCount>& high) {
  using Bits [[gnu::vector_size(sizeof(Score))]] = std::int32_t;
  using Floats [[gnu::vector_size(sizeof(Score))]] = float;
  Bits added;
  std::memcpy(&added, score.data(), sizeof added);
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const Split& s = candidates[c];
    const std::int32_t all_if_high = (s.threshold - (row[s.a] - row[s.b])) >> 31;  // no branch
    Floats sum;
    std::memcpy(&sum, high[c].data(), sizeof sum);
    sum += std::bit_cast<Floats>(added & all_if_high);
    std::memcpy(high[c].data(), &sum, sizeof sum);
  }
}

// What is left to go, summed by leaf.
IM2FIT_SIMD_CLONES void add_by_leaf(std::span<const Wide> residual, const std::uint8_t* leaf_of, WideSum* sums) {
  for (const Wide& r : residual) {
    WideSum& sum = sums[*leaf_of++];
    for (std::size_t d = 0; d < kWideSize; ++d) sum[d] += static_cast<double>(r[d]);
  }
}

// Of each coefficient with each.
IM2FIT_SIMD_CLONES void add_products(const Wide& r, WideSum* sums) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(kShapeSize); ++i)
    for (std::size_t j = 0; j < kWideSize; ++j) sums[i][j] += static_cast<double>(r[i]) * static_cast<double>(r[j]);
}

IM2FIT_SIMD_CLONES void take_away(const Sums& units, const WideBasis& basis, Wide& residual) {
  Wide r = residual;
  for (std::size_t k = 0; k < units.size(); ++k) {
    const auto amount = static_cast<float>(units[k]);
    for (std::size_t d = 0; d < kWideSize; ++d) r[d] -= amount * basis[k][d];
  }
  residual = r;
}

double anchor_spread_mm(int level) {
  return level < 3 ? 220 : (level < 6 ? 150 : 100);
}

class TreeGrower {
 public:
  TreeGrower(const Level& level, Rng rng) : level_(level), rng_(rng) {}

  Tree run() {
    Tree tree;
    const std::size_t count = level_.residual.size();
    std::vector<std::int32_t> order(count);
    for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<std::int32_t>(i);
    high_.resize(count);
    std::array<std::size_t, kSplitCount + kLeafCount + 1> first{};
    std::array<std::size_t, kSplitCount + kLeafCount + 1> last{};
    last[0] = count;
    for (std::size_t node = 0; node < static_cast<std::size_t>(kSplitCount); ++node) {
      const std::span<std::int32_t> mine(order.data() + first[node], last[node] - first[node]);
      tree.splits[node] = choose(mine);
      const std::size_t cut = first[node] + put_low_first(mine, tree.splits[node]);
      first[2 * node + 1] = first[node];
      last[2 * node + 1] = cut;
      first[2 * node + 2] = cut;
      last[2 * node + 2] = last[node];
    }
    tree.leaf_of.resize(count);
    std::array<std::size_t, static_cast<std::size_t>(kLeafCount)> sizes{};
    for (std::size_t leaf = 0; leaf < sizes.size(); ++leaf) {
      const std::size_t node = leaf + static_cast<std::size_t>(kSplitCount);
      sizes[leaf] = last[node] - first[node];
      for (std::size_t i = first[node]; i < last[node]; ++i)
        tree.leaf_of[static_cast<std::size_t>(order[i])] = static_cast<std::uint8_t>(leaf);
    }
    std::array<WideSum, static_cast<std::size_t>(kLeafCount)> sums{};
    add_by_leaf(level_.residual, tree.leaf_of.data(), sums.data());
    for (std::size_t leaf = 0; leaf < sizes.size(); ++leaf)
      fill_leaf(sums[leaf], sizes[leaf], tree.leaves.data() + leaf * static_cast<std::size_t>(kLeafSize));
    return tree;
  }

 private:
  // Starts whose difference is at most the threshold go to the front, in order; returns how many.
  std::size_t put_low_first(std::span<std::int32_t> mine, const Split& s) {
    const std::int16_t* a = level_.column(s.a);
    const std::int16_t* b = level_.column(s.b);
    std::size_t low = 0, high = 0;
    for (const std::int32_t i : mine) {  // no branch
      const bool is_high = a[i] - b[i] > s.threshold;
      mine[low] = high_[high] = i;
      low += is_high ? 0 : 1;
      high += is_high ? 1 : 0;
    }
    std::copy_n(high_.begin(), high, mine.begin() + static_cast<std::ptrdiff_t>(low));
    return low;
  }

  // Joints with larger residuals are drawn more often.
  int draw_joint() {
    double left = rng_.uniform();
    for (std::size_t j = 0; j + 1 < kJointCount; ++j) {
      left -= level_.joint_share[j];
      if (left < 0) return static_cast<int>(j);
    }
    return static_cast<int>(kJointCount) - 1;
  }

  Split draw() {
    Split s;
    for (int tries = 0; tries < 12; ++tries) {
      s.a = static_cast<std::uint16_t>(rng_.index(level_.pixel_count));
      s.b = static_cast<std::uint16_t>(rng_.index(level_.pixel_count));
      if (s.a == s.b) continue;
      const double dx = static_cast<double>(level_.where[s.a][0] - level_.where[s.b][0]);
      const double dy = static_cast<double>(level_.where[s.a][1] - level_.where[s.b][1]);
      if (rng_.uniform() < std::exp(-std::sqrt(dx * dx + dy * dy) / kPairReachMm)) break;
    }
    return s;
  }

  Split choose(std::span<const std::int32_t> mine) {
    Split best;
    best.b = 1;
    if (mine.size() < 20) return best;
    const std::size_t examined = std::min<std::size_t>(mine.size(), kExaminedMax);
    const std::size_t stride = mine.size() / examined;
    std::array<int, kScoreSize> dims{};
    for (int half = 0; half < 2; ++half) {
      const int joint = draw_joint();
      for (int k = 0; k < 3; ++k)
        dims[3 * static_cast<std::size_t>(half) + static_cast<std::size_t>(k)] = 3 * joint + k;
    }
    scores_.resize(examined);
    Score total{};
    for (std::size_t n = 0; n < examined; ++n) {
      const Wide& r = level_.left_to_go(mine[n * stride]);
      for (std::size_t d = 0; d < kScoreSize; ++d) scores_[n][d] = r[static_cast<std::size_t>(dims[d])];
      scores_[n][kScoreSize] = 1;  // counts
      for (std::size_t d = 0; d < kScoreSize; ++d) total[d] += scores_[n][d];
    }
    std::array<Split, kCandidateCount> candidates;
    for (Split& s : candidates) {
      s = draw();
      const std::int16_t* p = level_.row(mine[static_cast<std::size_t>(rng_.index(static_cast<int>(mine.size())))]);
      s.threshold = static_cast<std::int16_t>(p[s.a] - p[s.b] + static_cast<int>(rng_.normal(0, 10)));
    }
    // Start by start, so that its row of pixels is read from memory once for all candidates.
    std::array<Score, kCandidateCount> high{};
    for (std::size_t n = 0; n < examined; ++n) {
      const std::int16_t* q = level_.row(mine[n * stride]);
      if (n + 1 < examined) prefetch(level_.row(mine[(n + 1) * stride]));
      add_to_high(candidates, q, scores_[n], high);
    }
    float best_gain = -1;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const float high_count = high[c][kScoreSize], low_count = static_cast<float>(examined) - high_count;
      if (high_count < 5 || low_count < 5) continue;
      float gain = 0;
      for (std::size_t d = 0; d < kScoreSize; ++d) {
        const float low = total[d] - high[c][d];
        gain += high[c][d] * high[c][d] / high_count + low * low / low_count;
      }
      if (gain > best_gain) {
        best_gain = gain;
        best = candidates[c];
      }
    }
    return best;
  }

  void prefetch(const std::int16_t* row) const {
    constexpr int kLine = 64 / sizeof(std::int16_t);
    for (int i = 0; i < level_.pixel_count; i += kLine) __builtin_prefetch(row + i);
  }

  // `sum`: of the remaining steps of the `count` starts in it.
  void fill_leaf(const WideSum& sum, std::size_t count, std::int8_t* out) const {
    const double scale = kShrinkage / (static_cast<double>(count) + kLeafPrior);
    for (std::size_t k = 0; k < level_.units.size(); ++k) {
      double value = 0;
      for (std::size_t d = 0; d < static_cast<std::size_t>(kShapeSize); ++d)
        value += sum[d] * static_cast<double>(level_.units[k][d]);
      out[k] = static_cast<std::int8_t>(std::lround(std::clamp(value * scale, -127.0, 127.0)));
    }
  }

  const Level& level_;
  Rng rng_;
  std::vector<Score> scores_;
  std::vector<std::int32_t> high_;
};

std::vector<Anchor> draw_anchors(const TrainOptions& options, int level) {
  Rng rng = Rng::for_item(options.seed, kAnchorStream, static_cast<std::uint64_t>(level));
  std::vector<Anchor> out;
  const auto offset = [&](double spread_mm) {
    return static_cast<std::int16_t>(std::clamp(rng.normal(0, spread_mm), -2000.0, 2000.0));
  };
  for (int i = 0; i < options.pixel_count; ++i) {
    Anchor a;
    double spread_mm = anchor_spread_mm(level);
    a.joint = a.towards = static_cast<std::uint8_t>(rng.index(static_cast<int>(kJointCount)));
    if (rng.uniform() < kBetweenShare) {
      a.towards = static_cast<std::uint8_t>(rng.index(static_cast<int>(kJointCount)));
      a.share_q8 = static_cast<std::int16_t>(rng.index(257));
      spread_mm *= kBetweenSpread;
    }
    a.dx = offset(spread_mm);
    a.dy = offset(spread_mm);
    out.push_back(a);
  }
  return out;
}

void prepare(Level& level, std::span<const TrackerImage> images, std::span<const CascadeStart> starts, int threads) {
  level.pixels.resize(starts.size() * static_cast<std::size_t>(level.pixel_count));
  level.columns.resize(level.pixels.size());
  level.residual.resize(starts.size());
  const int chunk = 256;
  for_each_item(static_cast<int>((starts.size() + chunk - 1) / chunk), threads, [&](int item) {
    const std::size_t end =
        std::min(starts.size(), (static_cast<std::size_t>(item) + 1) * static_cast<std::size_t>(chunk));
    const std::size_t begin = static_cast<std::size_t>(item) * static_cast<std::size_t>(chunk);
    for (std::size_t i = begin; i < end; ++i) {
      const TrackerImage& image = images[static_cast<std::size_t>(starts[i].image)];
      joints::read_anchors(level.anchors, image.view, starts[i].shape,
                           level.pixels.data() + i * static_cast<std::size_t>(level.pixel_count));
      Wide& r = level.residual[i];
      r = {};
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const Vec3f d = image.truth[j] - joints::joint_of(starts[i].shape, static_cast<int>(j));
        r[3 * j] = d.x;
        r[3 * j + 1] = d.y;
        r[3 * j + 2] = d.z;
      }
    }
    for (std::size_t p = 0; p < static_cast<std::size_t>(level.pixel_count); ++p) {
      std::int16_t* column = level.columns.data() + p * starts.size();
      for (std::size_t i = begin; i < end; ++i) column[i] = level.row(static_cast<std::int32_t>(i))[p];
    }
  });
}

void subtract(Level& level, std::span<const Tree> trees, int threads) {
  WideBasis basis{};
  for (std::size_t k = 0; k < basis.size(); ++k)
    std::copy_n(level.basis.data() + k * static_cast<std::size_t>(kShapeSize), kShapeSize, basis[k].begin());
  const int chunk = 1024;
  const std::size_t count = level.sums.size();
  for_each_item(static_cast<int>((count + chunk - 1) / chunk), threads, [&](int item) {
    const std::size_t end = std::min(count, (static_cast<std::size_t>(item) + 1) * static_cast<std::size_t>(chunk));
    for (std::size_t i = static_cast<std::size_t>(item) * static_cast<std::size_t>(chunk); i < end; ++i) {
      Sums batch{};
      for (const Tree& tree : trees) {
        const std::int8_t* values = tree.leaves.data() + tree.leaf_of[i] * kLeafSize;
        for (std::size_t k = 0; k < batch.size(); ++k) batch[k] += values[k];
      }
      take_away(batch, basis, level.residual[i]);
      for (std::size_t k = 0; k < batch.size(); ++k) level.sums[i][k] += batch[k];
    }
  });
}

// The directions the level's residuals vary in most, each with a unit that lets a byte reach a few of its standard
// deviations. The next level fits the rest.
void choose_basis(Level& level) {
  std::array<WideSum, static_cast<std::size_t>(kShapeSize)> products{};
  for (const Wide& r : level.residual) add_products(r, products.data());
  Eigen::MatrixXd moments(kShapeSize, kShapeSize);
  for (int i = 0; i < kShapeSize; ++i)
    for (int j = 0; j < kShapeSize; ++j)
      moments(i, j) = products[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] /
                      static_cast<double>(level.residual.size());
  double sum = 0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto at = static_cast<Eigen::Index>(3 * j);
    level.joint_share[j] = std::sqrt(moments(at, at) + moments(at + 1, at + 1) + moments(at + 2, at + 2));
    sum += level.joint_share[j];
  }
  for (double& share : level.joint_share) share /= sum;
  const SymmetricEigen eigen = symmetric_eigen(moments);  // values rise
  for (int k = 0; k < kLeafSize; ++k) {
    const int column = kShapeSize - 1 - k;
    const double spread_mm = std::sqrt(std::max(0.0, eigen.values[column]));
    const double unit_mm = std::max(kUnitMinMm, kLeafReach * kShrinkage * spread_mm / 127);
    for (int d = 0; d < kShapeSize; ++d) {
      const double along = eigen.vectors(d, column);
      const auto at = static_cast<std::size_t>(k * kShapeSize + d);
      level.basis[at] = static_cast<float>(along * unit_mm);
      level.units[static_cast<std::size_t>(k)][static_cast<std::size_t>(d)] = static_cast<float>(along / unit_mm);
    }
  }
}

}  // namespace

Cascade train_cascade(std::span<const TrackerImage> images, std::vector<CascadeStart>& starts,
                      const TrainOptions& options, const std::function<void(double)>& progress) {
  Cascade cascade;
  joints::Shape mean{};
  for (const TrackerImage& image : images)
    for (int j = 0; j < static_cast<int>(kJointCount); ++j)
      joints::set_joint(
          mean, j,
          joints::joint_of(mean, j) + (image.truth[static_cast<std::size_t>(j)] - image.view.centroid_mm) *
                                          (1.0F / static_cast<float>(images.size())));
  Level level;
  level.pixel_count = options.pixel_count;
  for (int l = 0; l < options.level_count; ++l) {
    const std::vector<Anchor> anchors = draw_anchors(options, l);
    level.anchors = anchors;
    level.where.clear();
    for (const Anchor& a : anchors) {
      const Vec3f from = joints::joint_of(mean, a.joint);
      const Vec3f p = from + (joints::joint_of(mean, a.towards) - from) * (static_cast<float>(a.share_q8) / 256);
      level.where.push_back({p.x + static_cast<float>(a.dx), p.y + static_cast<float>(a.dy)});
    }
    prepare(level, images, starts, options.thread_count);
    level.sums.assign(starts.size(), Sums{});
    choose_basis(level);
    for (int t = 0; t < options.level_tree_count; t += kBatchTreeCount) {
      const int batch = std::min(kBatchTreeCount, options.level_tree_count - t);
      std::vector<Tree> trees(static_cast<std::size_t>(batch));
      for_each_item(batch, options.thread_count, [&](int b) {
        const int number = l * options.level_tree_count + t + b;
        const auto item = static_cast<std::uint64_t>(number);
        trees[static_cast<std::size_t>(b)] = TreeGrower(level, Rng::for_item(options.seed, kLevelStream, item)).run();
      });
      subtract(level, trees, options.thread_count);
      for (const Tree& tree : trees) {
        cascade.splits.insert(cascade.splits.end(), tree.splits.begin(), tree.splits.end());
        cascade.leaves.insert(cascade.leaves.end(), tree.leaves.begin(), tree.leaves.end());
      }
      if (progress) progress((l + static_cast<double>(t + batch) / options.level_tree_count) / options.level_count);
    }
    for (std::size_t i = 0; i < starts.size(); ++i)
      joints::add_sums(level.basis, level.sums[i].data(), starts[i].shape);
    cascade.anchors.insert(cascade.anchors.end(), anchors.begin(), anchors.end());
    cascade.basis.push_back(level.basis);
  }
  return cascade;
}

}  // namespace im2fit::lab
