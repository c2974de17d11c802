// SPDX-License-Identifier: Apache-2.0
#include "train/dataset/median_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/rng.h"
#include "kernels/average/average.h"

namespace im2fit::lab {
namespace {

constexpr int kWidth = 37, kHeight = 5, kStride = 41;  // no multiple of a vector, rows apart

std::vector<std::uint16_t> noisy_frame(Rng& rng) {
  std::vector<std::uint16_t> pixels(kStride * kHeight);
  for (auto& z : pixels)
    z = static_cast<std::uint16_t>(rng.index(4) == 0   ? 0
                                   : rng.index(3) == 0 ? 65535 - rng.index(3)
                                                       : 2000 + rng.index(40));
  return pixels;
}

TEST(MedianFrame, IsTheMiddleOneOfTheSortedWithNoDataLast) {
  Rng rng(5);
  MedianFrame median;
  for (const std::size_t count : {1, 3, 5, 7, 9, 29, 31, 4, 2, 30}) {
    std::vector<std::vector<std::uint16_t>> pixels;
    std::vector<DepthView> frames;
    for (std::size_t f = 0; f < count; ++f) pixels.push_back(noisy_frame(rng));
    for (const auto& p : pixels) frames.emplace_back(p.data(), kWidth, kHeight, kStride);
    std::vector<std::uint16_t> out(kStride * kHeight, 7);
    median.run(frames, {out.data(), kWidth, kHeight, kStride});
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kStride; ++u) {
        const auto at = static_cast<std::size_t>(v * kStride + u);
        std::vector<int> sorted;
        for (const auto& p : pixels) sorted.push_back(p[at] == 0 ? 65536 : p[at]);
        std::sort(sorted.begin(), sorted.end());
        const int middle = sorted[(count - 1) / 2] % 65536;
        ASSERT_EQ(out[at], u < kWidth ? middle : 7) << count << " frames, " << u << ", " << v;
      }
  }
}

TEST(MaskNear, KeepsWhatFusesWithTheMedian) {
  constexpr int kReach = static_cast<int>(kOutlierMm);
  const std::vector<std::uint16_t> median = {2000, 2000, 2000, 2000, 2000, 0, 65535, 30};
  const std::vector<std::uint16_t> frame = {
      2000, 2000 + kReach, 2000 + kReach + 1, 2000 - kReach, 2000 - kReach - 1, 0, 2, 0};
  const std::vector<std::uint8_t> mask = {255, 255, 255, 255, 255, 0, 255, 255};
  std::vector<std::uint8_t> out(mask.size(), 9);
  const int count = static_cast<int>(mask.size());
  mask_near({frame.data(), count, 1}, {median.data(), count, 1}, {mask.data(), count, 1}, {out.data(), count, 1});
  EXPECT_EQ(out, (std::vector<std::uint8_t>{255, 255, 0, 255, 0, 0, 0, 255}));
}

}  // namespace
}  // namespace im2fit::lab
