// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_person_votes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/rng.h"
#include "perception/joints/person_votes.h"
#include "train/tracker/tracker_detections.h"

namespace im2fit::lab {
namespace {

using joints::Anchor;
using joints::kClueCount;
using joints::kSpreadClues;
using joints::Split;

constexpr std::uint64_t kPersonVotesStream = 0x736D6264;
constexpr int kTreeCount = 300;
constexpr double kClueShare = 0.2;      // of the pairs compared
constexpr double kWithinGroup = 0.7;    // of the clues of joints: with another joint's
constexpr std::size_t kBlockSize = 64;  // examples; things of one room mostly stay together
constexpr std::size_t kFoldCount = 6;   // one of them is kept to calibrate on
constexpr double kAnchorSpreadMm = 130;
constexpr int kNewtonSteps = 25;
constexpr double kScaleMin = 0.05;

// Every second one between two joints, so that it goes with a limb.
std::vector<Anchor> draw_anchors(int count, Rng& rng) {
  const auto joint = [&] { return static_cast<std::uint8_t>(rng.index(static_cast<int>(kJointCount))); };
  const auto offset = [&] {
    return static_cast<std::int16_t>(std::clamp(rng.normal(0, kAnchorSpreadMm), -600.0, 600.0));
  };
  std::vector<Anchor> out;
  for (int i = 0; i < count; ++i) {
    Anchor a;
    a.joint = a.towards = joint();
    if (i % 2 == 1) {
      a.towards = joint();
      a.share_q8 = static_cast<std::int16_t>(rng.index(257));
    }
    a.dx = offset();
    a.dy = offset();
    out.push_back(a);
  }
  return out;
}

Split draw_pair(int pixel_count, Rng& rng) {
  const auto any = [&](int first, int count) { return static_cast<std::uint16_t>(first + rng.index(count)); };
  Split s;
  if (rng.uniform() >= kClueShare) {
    s.a = any(0, pixel_count);
    s.b = any(0, pixel_count);
    return s;
  }
  const int clue = 1 + rng.index(kClueCount - 1);
  s.a = static_cast<std::uint16_t>(pixel_count + clue);
  s.b = static_cast<std::uint16_t>(pixel_count);  // zero
  constexpr int kGroup = static_cast<int>(kJointCount);
  if (clue >= kSpreadClues && rng.uniform() < kWithinGroup)
    s.b = any(pixel_count + clue - (clue - kSpreadClues) % kGroup, kGroup);
  return s;
}

bool kept_back(std::size_t example) {
  return example / kBlockSize % kFoldCount == kFoldCount - 1;
}

VoteExamples select(const VoteExamples& all, bool kept) {
  VoteExamples out;
  out.value_count = all.value_count;
  const auto width = static_cast<std::ptrdiff_t>(all.value_count);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (kept_back(i) != kept) continue;
    const auto row = all.values.begin() + static_cast<std::ptrdiff_t>(i) * width;
    out.values.insert(out.values.end(), row, row + width);
    out.yes.push_back(all.yes[i]);
  }
  return out;
}

bool both_kinds(const VoteExamples& examples) {
  const auto yes = std::count(examples.yes.begin(), examples.yes.end(), 1);
  return yes > 0 && static_cast<std::size_t>(yes) < examples.size();
}

// What votes are worth on examples they have not learnt from: log-odds = scale x votes, by Newton's method, from a
// weak belief in 1.
double scale_of(const VoteTrees& trees, const VoteExamples& unseen) {
  double scale = 1;
  for (int step = 0; step < kNewtonSteps; ++step) {
    double slope = 1 - scale, bend = 1;
    for (std::size_t i = 0; i < unseen.size(); ++i) {
      const std::int16_t* values = unseen.values.data() + static_cast<std::ptrdiff_t>(i) * unseen.value_count;
      const double votes = static_cast<double>(joints::count_votes(trees.view(), values)) / joints::kVoteUnit;
      const double p = 1 / (1 + std::exp(-scale * votes));
      slope += (unseen.yes[i] - p) * votes;
      bend += p * (1 - p) * votes * votes;
    }
    scale = std::clamp(scale + std::clamp(slope / bend, -0.2, 0.2), kScaleMin, 1.0);
  }
  return scale;
}

}  // namespace

VoteTrees train_person_votes(const body::BodyModel& model, const JointModel& joint_model, const TrainOptions& options,
                             const std::function<void(double)>& progress) {
  Rng rng = Rng::for_item(options.seed, kPersonVotesStream, 0);
  VoteTrees out;
  out.anchors = draw_anchors(options.pixel_count, rng);
  const DetectionPlan plan = {options.image_count / 4, options.image_count, options.seed, options.thread_count};
  const VoteExamples all = collect_detections(model, joint_model, out.anchors, plan, progress);
  VoteExamples learnt = select(all, false);
  const VoteExamples unseen = select(all, true);
  if (!both_kinds(learnt)) return {};
  const DrawPair pair = [&](Rng& draws) { return draw_pair(options.pixel_count, draws); };
  train_votes(std::move(learnt), kTreeCount, pair, rng, out);
  const double scale = scale_of(out, unseen);
  for (std::int16_t& leaf : out.leaves) leaf = static_cast<std::int16_t>(std::lround(scale * leaf));
  return out;
}

}  // namespace im2fit::lab
