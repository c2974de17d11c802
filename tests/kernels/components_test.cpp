// SPDX-License-Identifier: Apache-2.0
#include "kernels/components/components.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "kernels/components/links.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

struct Field {
  int width, height;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> open;
};

// Patches of one surface each with noise, holes and closed cells.
Field random_field(checkasm::Trial& trial, int width, int height) {
  Field f{width, height, {}, {}};
  const int patch = 1 + trial.rng().index(6);
  std::vector<int> levels(64);
  for (int& level : levels) level = 900 + 70 * trial.rng().index(20);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int level = levels[static_cast<std::size_t>((v / patch * 7 + u / patch) % 64)];
      const int draw = trial.rng().index(10);
      f.depth.push_back(draw == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(level + trial.rng().index(50)));
      f.open.push_back(f.depth.back() != 0 && draw > 1 ? 1 : 0);
    }
  }
  return f;
}

bool one_surface(const Field& f, int a, int b) {
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  if (f.open[at(a)] == 0 || f.open[at(b)] == 0) return false;
  const double za = f.depth[at(a)], zb = f.depth[at(b)], z = std::min(za, zb);
  return std::fabs(za - zb) < 40 + 1.5 * 2.85e-6 * z * z;
}

// Flood fill with a stack: label by label from the first cell in reading order.
std::vector<std::uint16_t> flood(const Field& f, int cells_min, int count_max) {
  std::vector<std::uint16_t> labels(f.depth.size());
  std::vector<bool> seen(f.depth.size());
  int count = 0;
  for (int start = 0; start < f.width * f.height; ++start) {
    if (f.open[static_cast<std::size_t>(start)] == 0 || seen[static_cast<std::size_t>(start)]) continue;
    std::vector<int> members, stack = {start};
    seen[static_cast<std::size_t>(start)] = true;
    while (!stack.empty()) {
      const int here = stack.back();
      stack.pop_back();
      members.push_back(here);
      const int u = here % f.width, v = here / f.width;
      const auto visit = [&](int du, int dv, bool over_hole) {
        const int uu = u + du, vv = v + dv;
        if (uu < 0 || vv < 0 || uu >= f.width || vv >= f.height) return;
        const int other = vv * f.width + uu, between = (v + dv / 2) * f.width + u + du / 2;
        if (over_hole && f.depth[static_cast<std::size_t>(between)] != 0) return;
        if (seen[static_cast<std::size_t>(other)] || !one_surface(f, here, other)) return;
        seen[static_cast<std::size_t>(other)] = true;
        stack.push_back(other);
      };
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du)
          if (du != 0 || dv != 0) visit(du, dv, false);
      for (const auto& [du, dv] : std::array<std::pair<int, int>, 4>{{{2, 0}, {-2, 0}, {0, 2}, {0, -2}}})
        visit(du, dv, true);
    }
    if (static_cast<int>(members.size()) < cells_min || count == count_max) continue;
    ++count;
    for (const int i : members) labels[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(count);
  }
  return labels;
}

TEST(Components, AreThoseOfAFloodFill) {
  checkasm::Trial trial;
  for (int repeat = 0; repeat < 60; ++repeat) {
    const int width = 1 + trial.rng().index(50), height = 1 + trial.rng().index(30);
    const int cells_min = 1 + trial.rng().index(4), count_max = repeat % 3 == 0 ? 3 : 400;
    IM2FIT_CHECK_PARAMETERS(trial, repeat << ", " << width << 'x' << height);
    const Field f = random_field(trial, width, height);
    Components components(width, height);
    std::vector<std::uint16_t> labels(f.depth.size(), 9999);
    const int count = components.run(f.depth, f.open, cells_min, count_max, labels);
    const std::vector<std::uint16_t> want = flood(f, cells_min, count_max);
    ASSERT_EQ(labels, want);
    EXPECT_EQ(count, want.empty() ? 0 : *std::max_element(want.begin(), want.end()));
  }
}

TEST(Components, SpiralIsOneAndCheckerboardByItsCorners) {
  constexpr int kSide = 15;
  Field spiral{kSide, kSide, std::vector<std::uint16_t>(kSide * kSide, 2000),
               std::vector<std::uint8_t>(kSide * kSide)};
  int u = 0, v = 0, du = 1, dv = 0;
  const auto at = [](int x, int y) { return static_cast<std::size_t>(y * kSide + x); };
  const auto is_free = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < kSide && y < kSide && spiral.open[at(x, y)] == 0;
  };
  const auto clear_ahead = [&] {
    const int x = u + 2 * du, y = v + 2 * dv;
    return is_free(u + du, v + dv) && (x < 0 || y < 0 || x >= kSide || y >= kSide || spiral.open[at(x, y)] == 0);
  };
  spiral.open[at(0, 0)] = 1;
  for (int turns = 0; turns < 2;) {
    if (clear_ahead()) {
      u += du;
      v += dv;
      spiral.open[at(u, v)] = 1;
      turns = 0;
    } else {
      const int old = du;
      du = -dv;
      dv = old;
      ++turns;
    }
  }
  Components components(kSide, kSide);
  std::vector<std::uint16_t> labels(kSide * kSide);
  EXPECT_EQ(components.run(spiral.depth, spiral.open, 1, 400, labels), 1);
  for (std::size_t i = 0; i < labels.size(); ++i) EXPECT_EQ(labels[i], spiral.open[i]);
  Field board = spiral;
  for (int i = 0; i < kSide * kSide; ++i) board.open[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(i % 2);
  EXPECT_EQ(components.run(board.depth, board.open, 1, 400, labels), 1);
}

TEST(LinksCheck, EveryTierGivesTheSameBits) {
  checkasm::Trial trial;
  for (const int width : checkasm::odd_sizes(60)) {
    const int height = 1 + trial.rng().index(6);
    IM2FIT_CHECK_PARAMETERS(trial, width << 'x' << height);
    const auto size = static_cast<std::size_t>(width * height);
    checkasm::Buffer<std::uint16_t> depth(size, trial.next_end()), surface(size, trial.next_end()),
        limit(size, trial.next_end());
    const bool extremes = trial.rng().index(2) == 0;
    for (std::size_t i = 0; i < size; ++i) {
      const int draw = trial.rng().index(8);
      depth[i] = draw == 0  ? 0
                 : extremes ? trial.biased<std::uint16_t>(1, 65535)
                            : trial.biased<std::uint16_t>(2000, 2090);
      surface[i] = draw <= 1 ? 0 : depth[i];
      limit[i] = surface[i] == 0 ? 0
                 : extremes      ? trial.biased<std::uint16_t>(0, 65534)
                                 : trial.biased<std::uint16_t>(30, 60);
    }
    const LinkCells cells = {depth.data(), surface.data(), limit.data(), width, height};
    checkasm::Buffer<std::uint8_t> want(size), got(size, trial.next_end());
    links_ref(cells, want.data());
    links_portable(cells, got.data());
    checkasm::expect_same_bits(want, got);
    checkasm::each_simd(kLinksKernels, [&](const auto& variant) {
      got.refill();
      variant.function(cells, got.data());
      checkasm::expect_same_bits(want, got);
    });
  }
}

}  // namespace
}  // namespace im2fit
