// SPDX-License-Identifier: Apache-2.0
// Against pictures whose lost pixels are known.
#include "perception/fuse/outline_losses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/rng.h"

namespace im2fit {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr int kLeft = 120, kRight = 180, kTop = 40, kBottom = 200;  // the person, inclusive
constexpr int kPx = 5;                                              // of a shadow

// A person before a wall. `wall` 0: out of range.
struct Picture {
  explicit Picture(std::uint16_t wall = 3000) : depth(kWidth * kHeight, wall), mask(kWidth * kHeight, 0) {
    for (int v = kTop; v <= kBottom; ++v)
      for (int u = kLeft; u <= kRight; ++u) {
        depth[at(u, v)] = 2300;
        mask[at(u, v)] = 255;
      }
  }
  static std::size_t at(int u, int v) { return static_cast<std::size_t>(v * kWidth + u); }
  // No data in a rectangle, inclusive, but on the person.
  Picture& lose(int u0, int v0, int u1, int v1) {
    for (int v = v0; v <= v1; ++v)
      for (int u = u0; u <= u1; ++u)
        if (mask[at(u, v)] == 0) depth[at(u, v)] = 0;
    return *this;
  }
  Picture& lose_left() { return lose(kLeft - kPx, kTop, kLeft - 1, kBottom); }
  Picture& lose_right() { return lose(kRight + 1, kTop, kRight + kPx, kBottom); }
  void add_to(OutlineLosses& losses, int bottom = kBottom) const {
    losses.add({depth.data(), kWidth, kHeight}, {mask.data(), kWidth, kHeight}, kLeft, kTop, kRight, bottom);
  }
  OutlineLosses seen() const {
    OutlineLosses losses;
    for (int i = 0; i < 3; ++i) add_to(losses);
    return losses;
  }
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;
};

// Read are rows 40, 48 .. 200 and columns 120, 128 .. 176, two pixels at each end: 42, 42, 16 and 16.
TEST(OutlineLosses, AShadowOnAnySideIsSeen) {
  EXPECT_EQ(Picture().seen().one_sided(), 0);
  EXPECT_EQ(Picture().seen().lost(), 0);
  const OutlineLosses left = Picture().lose_left().seen(), right = Picture().lose_right().seen();
  const OutlineLosses above = Picture().lose(kLeft, kTop - kPx, kRight, kTop - 1).seen();
  const OutlineLosses below = Picture().lose(kLeft, kBottom + 1, kRight, kBottom + kPx).seen();
  for (const OutlineLosses& l : {left, right, above, below}) EXPECT_EQ(l.one_sided(), 1);
  for (const OutlineLosses& l : {left, right}) EXPECT_FLOAT_EQ(l.lost(), 42.0F / 116);
  for (const OutlineLosses& l : {above, below}) EXPECT_FLOAT_EQ(l.lost(), 16.0F / 116);
}

TEST(OutlineLosses, WhatIsLostOnBothSidesIsNoShadow) {
  const OutlineLosses both = Picture().lose_left().lose_right().seen();
  EXPECT_EQ(both.one_sided(), 0);
  EXPECT_FLOAT_EQ(both.lost(), 84.0F / 116);
}

TEST(OutlineLosses, CountsShares) {
  // Of the left side rows 40 to 119, ten of the 21 that are read.
  EXPECT_FLOAT_EQ(Picture().lose(kLeft - kPx, kTop, kLeft - 1, kTop + 79).seen().one_sided(), 10.0F / 21);
}

TEST(OutlineLosses, ABackgroundOutOfRangeLeavesItUnknown) {
  EXPECT_TRUE(std::isnan(Picture(0).seen().lost()));
  EXPECT_EQ(Picture(0).seen().one_sided(), 0);
  // To one side the room is out of range, to the other it is not.
  const OutlineLosses half = Picture().lose(0, 0, kLeft - 1, kHeight - 1).seen();
  EXPECT_EQ(half.one_sided(), 0);
  EXPECT_EQ(half.lost(), 0);
}

TEST(OutlineLosses, FewPixelsLeaveItUnknown) {
  const Picture p = Picture().lose_left();
  OutlineLosses losses;
  EXPECT_EQ(losses.one_sided(), 0);
  EXPECT_TRUE(std::isnan(losses.lost()));
  p.add_to(losses, kTop + 40);  // 6 rows of 2 pixels a side
  EXPECT_EQ(losses.one_sided(), 0);
  for (int i = 0; i < 2; ++i) p.add_to(losses, kTop + 40);
  EXPECT_EQ(losses.one_sided(), 1);
  losses.reset();
  EXPECT_EQ(losses.one_sided(), 0);
  EXPECT_TRUE(std::isnan(losses.lost()));
}

// Fifteen in a hundred beside the person, and single ones in the person, which do not count.
TEST(OutlineLosses, SinglePixelsAreLostOnAllSidesAlike) {
  Rng rng(11);
  OutlineLosses losses;
  const auto deep = [](int x, int first, int last) { return x > first + 3 && x < last - 3; };
  for (int i = 0; i < 20; ++i) {
    Picture p;
    for (int v = kTop - 6; v <= kBottom + 6; ++v)
      for (int u = kLeft - 6; u <= kRight + 6; ++u) {
        const bool inside = deep(u, kLeft, kRight) && deep(v, kTop, kBottom) && (u + 3 * v) % 7 == 0;
        const std::size_t at = Picture::at(u, v);
        if (p.mask[at] == 0 ? rng.uniform() >= 0.15 : !inside) continue;
        p.depth[at] = 0;
        p.mask[at] = 0;
      }
    p.add_to(losses);
  }
  EXPECT_LT(losses.one_sided(), 0.06F);
  EXPECT_NEAR(losses.lost(), 0.15F, 0.02F);
}

TEST(OutlineLosses, StaysWithinThePicture) {
  Picture p;
  OutlineLosses losses;
  std::fill(p.mask.begin(), p.mask.end(), std::uint8_t{255});
  losses.add({p.depth.data(), kWidth, kHeight}, {p.mask.data(), kWidth, kHeight}, -9, -9, kWidth + 9, kHeight + 9);
  EXPECT_TRUE(std::isnan(losses.lost()));
}

// After a few thousand pixels the answer stands.
TEST(OutlineLosses, ReadsTheFirstFrames) {
  const Picture shaded = Picture().lose_left();
  OutlineLosses losses;
  for (int i = 0; i < 60; ++i) shaded.add_to(losses);
  for (int i = 0; i < 60; ++i) Picture().add_to(losses);
  EXPECT_EQ(losses.one_sided(), 1);
}

}  // namespace
}  // namespace im2fit
