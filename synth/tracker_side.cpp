// SPDX-License-Identifier: Apache-2.0
#include "synth/tracker_side.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/rng.h"
#include "kernels/joints/side.h"
#include "synth/tracker_parallel.h"

namespace im2fit::synth {
namespace {

using joints::Anchor;
using joints::kLeafCount;
using joints::kSplitCount;
using joints::Split;

constexpr std::uint64_t kSideStream = 0x73696465;
constexpr int kTreeCount = 96;
constexpr int kCandidateCount = 120;
constexpr int kLookedMax = 1500;
constexpr double kShrinkage = 0.15;
constexpr double kLeafPrior = 4;  // of the Hessian
constexpr double kStepMax = 2;    // log-odds a leaf may add before shrinkage

class SideTrainer {
 public:
  SideTrainer(std::vector<std::int16_t> pixels, int pixel_count, std::vector<std::uint8_t> back, Rng rng)
      : pixels_(std::move(pixels)), pixel_count_(pixel_count), back_(std::move(back)), rng_(rng) {
    score_.resize(back_.size());
    slope_.resize(back_.size());
    bend_.resize(back_.size());
  }

  void add_tree(SideTrees& out) {
    for (std::size_t i = 0; i < back_.size(); ++i) {
      const double p = 1 / (1 + std::exp(-static_cast<double>(score_[i]) / joints::kSideUnit));
      slope_[i] = static_cast<float>(back_[i] - p);
      bend_[i] = static_cast<float>(std::max(p * (1 - p), 1e-6));
    }
    std::vector<std::int32_t> order(back_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
    std::array<std::size_t, kSplitCount + kLeafCount> first{}, last{};
    last[0] = order.size();
    for (std::size_t node = 0; node < first.size(); ++node) {
      const std::span<std::int32_t> mine(order.data() + first[node], last[node] - first[node]);
      if (node >= static_cast<std::size_t>(kSplitCount)) {
        out.leaves.push_back(leaf(mine));
        for (const std::int32_t i : mine) score_[static_cast<std::size_t>(i)] += out.leaves.back();
        continue;
      }
      const Split s = choose(mine);
      out.splits.push_back(s);
      const auto middle = std::stable_partition(mine.begin(), mine.end(),
                                                [&](std::int32_t i) { return difference(i, s) <= s.threshold; });
      const std::size_t cut = first[node] + static_cast<std::size_t>(middle - mine.begin());
      first[2 * node + 1] = first[node];
      last[2 * node + 1] = first[2 * node + 2] = cut;
      last[2 * node + 2] = last[node];
    }
  }

 private:
  int difference(std::int32_t i, const Split& s) const {
    const std::int16_t* row = pixels_.data() + static_cast<std::ptrdiff_t>(i) * pixel_count_;
    return row[s.a] - row[s.b];
  }

  Split choose(std::span<const std::int32_t> mine) {
    Split best;
    best.b = 1;
    if (mine.size() < 20) return best;
    const std::size_t stride = std::max<std::size_t>(1, mine.size() / kLookedMax);
    float best_gain = -1;
    for (int c = 0; c < kCandidateCount; ++c) {
      Split s;
      s.a = static_cast<std::uint8_t>(rng_.index(pixel_count_));
      s.b = static_cast<std::uint16_t>(rng_.index(pixel_count_));
      if (s.a == s.b) continue;
      const std::int32_t like = mine[static_cast<std::size_t>(rng_.index(static_cast<int>(mine.size())))];
      s.threshold = static_cast<std::int16_t>(difference(like, s) + static_cast<int>(rng_.normal(0, 10)));
      std::array<float, 2> slope{}, bend{};
      for (std::size_t n = 0; n < mine.size(); n += stride) {
        const std::size_t right = difference(mine[n], s) > s.threshold ? 1 : 0;
        slope[right] += slope_[static_cast<std::size_t>(mine[n])];
        bend[right] += bend_[static_cast<std::size_t>(mine[n])];
      }
      const auto gain_of = [&](std::size_t k) {
        return slope[k] * slope[k] / (bend[k] + static_cast<float>(kLeafPrior));
      };
      const float gain = gain_of(0) + gain_of(1);
      if (gain <= best_gain) continue;
      best_gain = gain;
      best = s;
    }
    return best;
  }

  // Newton's step.
  std::int16_t leaf(std::span<const std::int32_t> mine) const {
    double slope = 0, bend = kLeafPrior;
    for (const std::int32_t i : mine) {
      slope += static_cast<double>(slope_[static_cast<std::size_t>(i)]);
      bend += static_cast<double>(bend_[static_cast<std::size_t>(i)]);
    }
    const double step = kShrinkage * std::clamp(slope / bend, -kStepMax, kStepMax);
    return static_cast<std::int16_t>(std::lround(step * joints::kSideUnit));
  }

  std::vector<std::int16_t> pixels_;  // examples * pixel_count
  int pixel_count_;
  std::vector<std::uint8_t> back_;
  Rng rng_;
  std::vector<int> score_;
  std::vector<float> slope_, bend_;  // first and second derivative of the log-likelihood
};

std::vector<Anchor> draw_anchors(int count, Rng& rng) {
  std::vector<Anchor> out;
  for (int i = 0; i < count; ++i) {
    Anchor a;
    a.joint = a.towards = static_cast<std::uint8_t>(rng.index(static_cast<int>(kJointCount)));
    a.dx = static_cast<std::int16_t>(std::clamp(rng.normal(0, 110), -600.0, 600.0));
    a.dy = static_cast<std::int16_t>(std::clamp(rng.normal(0, 110), -600.0, 600.0));
    out.push_back(a);
  }
  return out;
}

}  // namespace

SideTrees train_side(std::span<const TrackerImage> images, std::span<const SideExample> examples,
                     const TrainOptions& options) {
  std::vector<std::uint8_t> back(examples.size());
  for (std::size_t i = 0; i < examples.size(); ++i)
    back[i] = images[static_cast<std::size_t>(examples[i].image)].back ? 1 : 0;
  const auto backs = static_cast<std::size_t>(std::count(back.begin(), back.end(), 1));
  SideTrees out;
  if (backs == 0 || backs == back.size()) return out;
  Rng rng = Rng::for_item(options.seed, kSideStream, 0);
  out.anchors = draw_anchors(options.pixel_count, rng);
  const auto width = static_cast<std::size_t>(options.pixel_count);
  std::vector<std::int16_t> pixels(examples.size() * width);
  for_each_item(static_cast<int>(examples.size()), options.thread_count, [&](int item) {
    const auto i = static_cast<std::size_t>(item);
    joints::read_anchors(out.anchors, images[static_cast<std::size_t>(examples[i].image)].view, examples[i].shape,
                         pixels.data() + i * width);
  });
  SideTrainer trainer(std::move(pixels), options.pixel_count, std::move(back), rng);
  for (int t = 0; t < kTreeCount; ++t) trainer.add_tree(out);
  return out;
}

}  // namespace im2fit::synth
