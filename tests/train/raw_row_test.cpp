// SPDX-License-Identifier: Apache-2.0
// The sensor's innermost loop against the same arithmetic written pixel by pixel.
#include "train/render/raw_row.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/rng.h"

namespace im2fit::lab {
namespace {

std::int32_t pixel(const RawRow& row, int i) {
  Rng draws(row.seed + kRowStep * static_cast<std::uint64_t>(i));
  const std::uint64_t bits = draws.next();
  Rng again(row.seed + kRowStep * static_cast<std::uint64_t>(i));
  const float white = again.fast_normal();
  const auto chance = static_cast<std::int32_t>((bits * 0xD1342543DE82EF95ULL) >> 48);
  const float raw = row.exact[i] + row.sigma[i] * (row.white_share * white + row.patch_share * row.patch[i]);
  if (chance < row.lost[i] || raw < -0.5F) return 2048;
  return raw + 0.5F > 2047.0F ? 2047 : static_cast<std::int32_t>(raw + 0.5F);
}

TEST(RawRow, EveryVariantIsThePixelsArithmetic) {
  std::vector<RawRowFunction*> variants = {raw_row_portable, fastest_raw_row()};
  Rng rng(3);
  for (int trial = 0; trial < 400; ++trial) {
    const int count = 1 + rng.index(200);
    const auto n = static_cast<std::size_t>(count);
    std::vector<float> exact(n), sigma(n), patch(n);
    std::vector<std::int32_t> lost(n), out(n);
    for (std::size_t i = 0; i < n; ++i) {
      // Mostly ordinary; at both ends of the steps, far beyond them, and surely lost.
      const int kind = rng.index(8);
      exact[i] = static_cast<float>(kind == 0   ? rng.uniform(-2, 2)
                                    : kind == 1 ? rng.uniform(2045, 2050)
                                    : kind == 2 ? rng.uniform(-1e5, 1e6)
                                                : rng.uniform(300, 1000));
      sigma[i] = static_cast<float>(rng.uniform(0, kind == 3 ? 500 : 2));
      patch[i] = rng.fast_normal();
      lost[i] = kind == 4 ? 65536 : kind == 5 ? rng.index(65536) : rng.index(40);
    }
    const bool silent = trial % 10 == 0;
    const RawRow row{rng.next(),   exact.data(),         sigma.data(),         lost.data(),
                     patch.data(), silent ? 0.0F : 0.7F, silent ? 0.0F : 0.71F};
    for (RawRowFunction* variant : variants) {
      variant(row, count, out.data());
      for (int i = 0; i < count; ++i)
        ASSERT_EQ(out[static_cast<std::size_t>(i)], pixel(row, i)) << "trial " << trial << " pixel " << i;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint64_t bits = Rng(row.seed + kRowStep * i).next();
      const RawPixel alone{bits, exact[i], sigma[i], lost[i], patch[i], row.white_share, row.patch_share};
      ASSERT_EQ(raw_step(alone), pixel(row, static_cast<int>(i))) << "trial " << trial << " pixel " << i;
    }
  }
}

}  // namespace
}  // namespace im2fit::lab
