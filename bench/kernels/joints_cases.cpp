// SPDX-License-Identifier: Apache-2.0
// The tracker's kernels on a random model of the shipped size.
#include <cstdint>
#include <memory>
#include <vector>

#include "bench/kernels/cases.h"
#include "core/rng.h"
#include "kernels/downsample/downsample_box.h"
#include "kernels/trees/trees.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {
namespace {

// One frame's cascade: ten levels of 600 trees for six runs. Every tier answers all splits of a tree for eight runs
// at once; AVX2 and NEON quicken the adding only, so that neither reaches twice portable, whose vectors of eight the
// compiler makes for any machine that has them.
void add_trees(Cases& cases) {
  using namespace joints;
  constexpr int kLevels = 10, kTrees = 600, kPixels = 400, kRuns = 6;
  struct Data {
    std::vector<Split> splits = std::vector<Split>(kLevels * kTrees * kSplitCount);
    std::vector<std::int8_t> leaves = std::vector<std::int8_t>(kLevels * kTrees * kLeafCount * kLeafSize);
    std::vector<std::int16_t> pixels = std::vector<std::int16_t>(kPixels * kRunLanes);
  };
  const auto data = std::make_shared<Data>();
  Rng rng(1);
  for (Split& s : data->splits)
    s = {static_cast<std::uint16_t>(rng.index(kPixels)), static_cast<std::uint16_t>(rng.index(kPixels)),
         static_cast<std::int16_t>(rng.index(401) - 200)};
  for (std::int8_t& v : data->leaves) v = static_cast<std::int8_t>(rng.index(200) - 100);
  for (std::int16_t& v : data->pixels) v = static_cast<std::int16_t>(rng.index(1201) - 600);
  constexpr double kCount = kLevels * kTrees;
  const Floor floor = {kCount * (31 * 5 + 2 * kRuns) / 2 / 2500, "5 loads a split, 2 a leaf, two loads a cycle"};
  add_variants(cases, "joints_trees/6x10x600", kSumLeavesWithRef, kCount, "tree", floor, true, [&](auto* function) {
    return [data, function] {
      std::int32_t sum[kRuns * kLeafSize] = {};
      for (std::size_t level = 0; level < kLevels; ++level)
        function(data->splits.data() + level * kTrees * kSplitCount,
                 data->leaves.data() + level * kTrees * kLeafCount * kLeafSize, kTrees, data->pixels.data(), kRuns,
                 sum);
      keep(sum[0]);
    };
  });
}

// A standing person's box in a 480x640 frame.
void add_thin(Cases& cases) {
  using namespace joints;
  constexpr int kWidth = 480, kHeight = 640;
  struct Data {
    std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kWidth * kHeight);
    std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(kWidth * kHeight);
    std::vector<std::uint16_t> out = std::vector<std::uint16_t>(110 * 225);
  };
  const auto data = std::make_shared<Data>();
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto i = static_cast<std::size_t>(v * kWidth + u);
      data->depth[i] = static_cast<std::uint16_t>(2000 + u);
      data->mask[i] = u > 190 && u < 290 ? 255 : 0;
    }
  }
  const DownsampleBox box = {DepthView(data->depth.data(), kWidth, kHeight),
                             MaskView(data->mask.data(), kWidth, kHeight),
                             2,
                             65,
                             50,
                             110,
                             225};
  constexpr double kPixels = 220 * 450;
  const Floor floor = {kPixels * 3 / 32 / 2 / 2500, "3 bytes read a pixel, two loads of 32 bytes a cycle"};
  add_variants(cases, "joints_thin/220x450", kDownsampleBoxWithRef, kPixels, "px", floor, true, [&](auto* function) {
    return [data, box, function] {
      DownsampleMoments moments;
      function(box, data->out.data(), moments);
      keep(moments);
    };
  });
}

}  // namespace

void add_joints_cases(Cases& cases) {
  add_trees(cases);
  add_thin(cases);
}

}  // namespace im2fit::bench
