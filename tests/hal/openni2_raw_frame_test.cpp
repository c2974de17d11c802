// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hal/openni2/raw_frame.h"
#include "support.h"

namespace im2fit::hal {
namespace {

TEST(RawFrame, CropsMirrorsAndUnitsAreUndone) {
  const std::uint16_t data[] = {10, 20, 99, 34, 44, 99};  // 2 x 2 with a padded stride
  Picture out(4, 3);
  out.pixels.assign(out.pixels.size(), 7);
  RawFrame frame{data, sizeof data, 2, 2, 6, 1, 1, 1000, false};
  ASSERT_TRUE(copy_raw_frame(frame, out.image()));
  EXPECT_EQ(out.pixels, (std::vector<std::uint16_t>{0, 0, 0, 0, 0, 10, 20, 0, 0, 34, 44, 0}));
  frame.crop_x = 0;
  frame.mirrored = true;
  frame.unit_um = 100;
  ASSERT_TRUE(copy_raw_frame(frame, out.image()));
  EXPECT_EQ(out.pixels, (std::vector<std::uint16_t>{0, 0, 0, 0, 0, 0, 2, 1, 0, 0, 4, 3}));
}

TEST(RawFrame, SizesThatDoNotFitAreRefused) {
  std::vector<std::uint16_t> data(12);
  Picture out(4, 3);
  const RawFrame good{data.data(), 24, 4, 3, 8, 0, 0, 1000, false};
  ASSERT_TRUE(copy_raw_frame(good, out.image()));
  const auto refused = [&](auto change) {
    RawFrame bad = good;
    change(bad);
    return !copy_raw_frame(bad, out.image());
  };
  EXPECT_TRUE(refused([](RawFrame& f) { f.data = nullptr; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.size_bytes = 23; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.width = 5; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.height = 4; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.height = 0; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.crop_x = 1; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.crop_y = -1; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.stride_bytes = 6; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.stride_bytes = 1 << 30; }));
  EXPECT_TRUE(refused([](RawFrame& f) { f.unit_um = 1; }));
}

}  // namespace
}  // namespace im2fit::hal
