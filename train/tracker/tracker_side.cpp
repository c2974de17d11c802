// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_side.h"

#include <algorithm>
#include <utility>

#include "core/rng.h"
#include "train/common/parallel.h"

namespace im2fit::lab {
namespace {

using joints::Anchor;
using joints::Split;

constexpr std::uint64_t kSideStream = 0x73696465;
constexpr int kTreeCount = 96;
constexpr int kFirstCount = 256;  // of a pair, the one is among so many anchors

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

VoteTrees train_side(std::span<const TrackerImage> images, std::span<const SideExample> examples,
                     const TrainOptions& options) {
  VoteExamples seen;
  seen.value_count = options.pixel_count;
  seen.yes.resize(examples.size());
  for (std::size_t i = 0; i < examples.size(); ++i)
    seen.yes[i] = images[static_cast<std::size_t>(examples[i].image)].back ? 1 : 0;
  const auto backs = static_cast<std::size_t>(std::count(seen.yes.begin(), seen.yes.end(), 1));
  VoteTrees out;
  if (backs == 0 || backs == seen.size()) return out;
  Rng rng = Rng::for_item(options.seed, kSideStream, 0);
  out.anchors = draw_anchors(options.pixel_count, rng);
  const auto width = static_cast<std::size_t>(options.pixel_count);
  seen.values.resize(examples.size() * width);
  for_each_item(static_cast<int>(examples.size()), options.thread_count, [&](int item) {
    const auto i = static_cast<std::size_t>(item);
    joints::read_anchors(out.anchors, images[static_cast<std::size_t>(examples[i].image)].view, examples[i].shape,
                         seen.values.data() + i * width);
  });
  const DrawPair any_pair = [&](Rng& draws) {
    Split s;
    s.a = static_cast<std::uint16_t>(draws.index(options.pixel_count) % kFirstCount);
    s.b = static_cast<std::uint16_t>(draws.index(options.pixel_count));
    return s;
  };
  train_votes(std::move(seen), kTreeCount, any_pair, rng, out);
  return out;
}

}  // namespace im2fit::lab
