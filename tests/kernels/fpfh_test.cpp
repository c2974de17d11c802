// SPDX-License-Identifier: Apache-2.0
#include "kernels/fpfh/fpfh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "kernels/fpfh/fpfh_pair.h"
#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit {
namespace {

using test::FigureCloud;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

OrganisedCloud view(const FigureCloud& c) {
  return {c.intrinsics, c.x.data(), c.y.data(), c.z.data(), c.nx.data(), c.ny.data(), c.nz.data()};
}

FigureCloud empty_cloud(Intrinsics k) {
  return test::render_cloud({}, k, 0, 0, 0, 0);
}

void put(FigureCloud& c, int u, int v, float z_mm, Vec3f normal) {
  const auto i = static_cast<std::size_t>(v * c.intrinsics.width + u);
  const Vec3f p = unproject(c.intrinsics, static_cast<float>(u), static_cast<float>(v), z_mm);
  c.x[i] = p.x, c.y[i] = p.y, c.z[i] = p.z;
  c.nx[i] = normal.x, c.ny[i] = normal.y, c.nz[i] = normal.z;
}

std::vector<float> run(const FpfhKernel& kernel, const FigureCloud& c, const std::vector<Vec3f>& keypoints,
                       float radius_mm = kFpfhRadiusMm) {
  FpfhWorkspace work(c.intrinsics.width, c.intrinsics.height);
  std::vector<float> out(keypoints.size() * kFpfhSize, -1.0F);
  kernel.function(view(c), keypoints, radius_mm, work, out);
  return out;
}

std::array<float, kFpfhSize> bins(std::initializer_list<std::pair<int, float>> values) {
  std::array<float, kFpfhSize> out{};
  for (const auto& [bin, value] : values) out[static_cast<std::size_t>(bin)] = value;
  return out;
}

void expect_descriptor(const std::vector<float>& out, const std::array<float, kFpfhSize>& want) {
  for (std::size_t b = 0; b < kFpfhSize; ++b) EXPECT_NEAR(out[b], want[b], 1e-3F) << "bin " << b;
}

class Fpfh : public testing::TestWithParam<FpfhKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Fpfh, testing::ValuesIn(kFpfhWithRef),
                         [](const auto& p) { return std::string(p.param.name); });

constexpr Intrinsics kSmall = {40, 30, 50, 50, 19.5F, 14.5F};

TEST_P(Fpfh, NothingInRangeGivesZeros) {
  FigureCloud c = empty_cloud(kSmall);
  expect_descriptor(run(GetParam(), c, {{0, 0, 1000}}), {});
  put(c, 20, 15, 1000, {0, 0, -1});
  expect_descriptor(run(GetParam(), c, {{0, 0, 1500}}), {});
  expect_descriptor(run(GetParam(), c, {{kNan, 0, 1000}}), {});
}

TEST_P(Fpfh, APointAloneHasNoPairs) {
  FigureCloud c = empty_cloud(kSmall);
  put(c, 20, 15, 1000, {0, 0, -1});
  expect_descriptor(run(GetParam(), c, {{0, 0, 1000}}), {});
}

TEST_P(Fpfh, PlaneFallsIntoTheMiddleBins) {
  FigureCloud c = empty_cloud(kSmall);
  for (int v = 0; v < kSmall.height; ++v) {
    for (int u = 0; u < kSmall.width; ++u) put(c, u, v, 1000, {0, 0, -1});
  }
  // Corners too: a neighbourhood cut by the picture's border.
  for (const Vec3f at : {Vec3f{0, 0, 1000}, Vec3f{-390, -290, 1000}, Vec3f{390, 290, 1010}}) {
    expect_descriptor(run(GetParam(), c, {at}), bins({{5, 100}, {16, 100}, {27, 100}}));
  }
}

// Two points on a ridge: d = (1, 0, 0), normals tilted towards and away along d and about it.
TEST_P(Fpfh, TwoPointsByHand) {
  FigureCloud c = empty_cloud(kSmall);
  const float s = std::sin(0.7F), co = std::cos(0.7F);
  put(c, 20, 15, 1000, {s, 0, -co});        // a1 = sin 0.7 = 0.644
  put(c, 21, 15, 1000, {0, -0.6F, -0.8F});  // a2 = 0: no swap
  // d = x. v = d x n1 / |.| = (0, co, 0)/co = (0, 1, 0); f2 = v.n2 = -0.6. w = n1 x v = (co, 0, s);
  // w.n2 = -0.8 s = -0.5154; n1.n2 = 0.8 co = 0.6119; f1 = -0.7 -> bin floor(11 (pi - 0.7)/2pi) = 4.
  // f2 bin = floor(5.5 * 0.4) = 2; f3 bin = floor(5.5 * 1.644) = 9. From the other point the rule swaps: the same.
  expect_descriptor(run(GetParam(), c, {{0, 0, 1000}}), bins({{4, 100}, {11 + 2, 100}, {22 + 9, 100}}));
}

TEST_P(Fpfh, CoincidentPointsCountInTheMiddle) {
  FigureCloud c = empty_cloud(kSmall);
  put(c, 20, 15, 1000, {0, 0.6F, -0.8F});
  put(c, 21, 15, 1000, {0, -0.6F, -0.8F});
  // The same position in two pixels, each within half a pixel of its own.
  const std::size_t i = static_cast<std::size_t>(15 * kSmall.width + 20);
  c.x[i] = c.x[i + 1] = 20.0F;
  const std::vector<Vec3f> keypoint = {{0, 0, 1000}};
  expect_descriptor(run(GetParam(), c, keypoint), bins({{5, 100}, {16, 100}, {27, 100}}));
  // A missing normal does not change that.
  c.nx[i] = c.ny[i] = c.nz[i] = kNan;
  expect_descriptor(run(GetParam(), c, keypoint), bins({{5, 100}, {16, 100}, {27, 100}}));
}

// d parallel to the source's normal: v = 0.
TEST_P(Fpfh, NormalAlongTheLineCountsInTheMiddle) {
  Intrinsics k = kSmall;
  k.cx = 20.5F, k.cy = 15;
  FigureCloud c = empty_cloud(k);
  put(c, 20, 15, 1000, {0, 0, -1});
  put(c, 21, 15, 1100, {0, 0, -1});
  // Both on the ray between the two pixels, one straight behind the other.
  const std::size_t i = static_cast<std::size_t>(15 * k.width + 20);
  c.x[i] = c.x[i + 1] = 0.0F;
  expect_descriptor(run(GetParam(), c, {{0, 50, 1000}}), bins({{5, 100}, {16, 100}, {27, 100}}));
}

TEST_P(Fpfh, MissingNormals) {
  FigureCloud c = empty_cloud(kSmall);
  const float s = std::sin(0.7F), co = std::cos(0.7F);
  put(c, 20, 15, 1000, {s, 0, -co});
  put(c, 21, 15, 1000, {kNan, kNan, kNan});
  // The keypoint stands on the first point, whose weight is skipped: only the blank point's SPFH, all bin 0.
  const std::size_t i = static_cast<std::size_t>(15 * kSmall.width + 20);
  const Vec3f first = {c.x[i], c.y[i], c.z[i]}, second = {c.x[i + 1], c.y[i + 1], c.z[i + 1]};
  expect_descriptor(run(GetParam(), c, {first}), bins({{0, 100}, {11, 100}, {22, 100}}));
  // On the blank point: the first point's SPFH; f3 = sin 0.7 is known.
  expect_descriptor(run(GetParam(), c, {second}), bins({{0, 100}, {11, 100}, {22 + 9, 100}}));
}

TEST_P(Fpfh, RadiusIsStrict) {
  FigureCloud c = empty_cloud(kSmall);
  put(c, 10, 15, 1000, {0, 0, -1});
  put(c, 20, 15, 1000, {0, 0, -1});
  const std::size_t i = static_cast<std::size_t>(15 * kSmall.width + 10);
  const float apart_mm = c.x[i + 10] - c.x[i];
  EXPECT_FLOAT_EQ(apart_mm, 200.0F);
  const Vec3f between = {c.x[i] + 100, c.y[i], 1000};
  expect_descriptor(run(GetParam(), c, {between}, 200.1F), bins({{5, 100}, {16, 100}, {27, 100}}));
  expect_descriptor(run(GetParam(), c, {between}, 199.9F), {});
}

// Random curved, noisy clouds at the borders of the picture, with missing normals and a camera that is very near:
// brute force in double against row ranges in float.
double worst_l1(const FpfhKernel& kernel, const FigureCloud& c, const std::vector<Vec3f>& keypoints,
                float radius_mm) {
  const std::vector<float> want = run(kFpfhWithRef[0], c, keypoints, radius_mm);
  const std::vector<float> got = run(kernel, c, keypoints, radius_mm);
  double worst = 0;
  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    double l1 = 0;
    for (std::size_t b = 0; b < kFpfhSize; ++b) {
      l1 += std::fabs(double{got[k * kFpfhSize + b]} - double{want[k * kFpfhSize + b]});
    }
    worst = std::max(worst, l1);
  }
  return worst;
}

std::vector<Vec3f> joint_keypoints(const test::Figure& figure) {
  return {figure.joints.position_mm.begin(), figure.joints.position_mm.end()};
}

TEST_P(Fpfh, AgreesWithRefOnANoisyFigure) {
  ASSERT_STREQ(kFpfhWithRef[0].name, "ref");
  const Intrinsics portrait = {90, 130, 105, 105, 44.5F, 64.5F}, coarse = {40, 50, 46, 46, 19.5F, 24.5F};
  struct Case {
    Intrinsics intrinsics;
    float x, z, lift;
    double noise, tilt, missing;
  };
  // In order: whole figure; cut by the right and lower border; a third of the normals missing; very near.
  const Case cases[] = {{portrait, 0, 2300, 0, 3, 0.1, 0.0},
                        {portrait, 500, 1800, 500, 3, 0.3, 0.1},
                        {portrait, 0, 2300, 0, 6, 0.5, 0.33},
                        {coarse, 0, 420, 0, 1, 0.1, 0.05}};
  for (const Case& t : cases) {
    const test::Figure figure = test::standing_figure(t.x, t.z, t.lift);
    const FigureCloud c = test::render_cloud(figure, t.intrinsics, t.noise, t.tilt, t.missing, 7);
    ASSERT_GT(c.valid_count, 900);
    // PCL's bar is 0.01 of 300 (float rounding at bin edges); one pair of ~200 in one SPFH of ~200 is 0.005.
    EXPECT_LE(worst_l1(GetParam(), c, joint_keypoints(figure), kFpfhRadiusMm), 0.01) << t.x << ' ' << t.z;
  }
}

// Points anywhere within half a pixel of their own, at random depths: the row ranges must lose none.
TEST_P(Fpfh, LosesNoNeighbourWithinHalfAPixel) {
  Rng rng(11);
  for (int trial = 0; trial < 12; ++trial) {
    const Intrinsics k = {24, 32, 30, 26, 4.5F, 20.5F};
    FigureCloud c = empty_cloud(k);
    std::vector<Vec3f> keypoints;
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        if (rng.uniform() < 0.3) continue;
        const Vec3f n = normalized(
            {static_cast<float>(rng.normal()), static_cast<float>(rng.normal()), static_cast<float>(rng.normal())});
        const float z = static_cast<float>(rng.uniform(150, 700));
        put(c, u, v, z, n);
        const auto i = static_cast<std::size_t>(v * k.width + u);
        const Vec3f p = unproject(k, static_cast<float>(u + rng.uniform(-0.5, 0.5)),
                                  static_cast<float>(v + rng.uniform(-0.5, 0.5)), z);
        c.x[i] = p.x, c.y[i] = p.y;
        if (rng.uniform() < 0.05) c.nx[i] = c.ny[i] = c.nz[i] = kNan;
        if (rng.uniform() < 0.02) keypoints.push_back(p + Vec3f{5, -3, 4});
      }
    }
    EXPECT_LE(worst_l1(GetParam(), c, keypoints, 120.0F), 0.01) << "trial " << trial;
  }
}

TEST_P(Fpfh, DescriptorsDoNotDependOnTheCompany) {
  const test::Figure figure = test::standing_figure(0, 2300);
  const FigureCloud c = test::render_cloud(figure, {45, 65, 52, 52, 22, 32}, 3, 0.2, 0.1, 3);
  const std::vector<Vec3f> all = joint_keypoints(figure);
  const std::vector<float> together = run(GetParam(), c, all);
  for (std::size_t k = 0; k < all.size(); k += 4) {
    const std::vector<float> alone = run(GetParam(), c, {all[k]});
    for (std::size_t b = 0; b < kFpfhSize; ++b) EXPECT_EQ(alone[b], together[k * kFpfhSize + b]);
  }
}

// Within an ulp of the truth everywhere, and never rising: ties stay ties, orders are never reversed.
TEST(FpfhPair, ArcCosine) {
  using fpfh_detail::arc_cosine;
  float previous = arc_cosine(0.0F);
  for (std::uint32_t bits = 0; bits <= std::bit_cast<std::uint32_t>(1.0F); bits += 1013) {
    const float a = std::bit_cast<float>(bits);
    ASSERT_NEAR(arc_cosine(a), std::acos(double{a}), 1.2e-7) << a;
    ASSERT_LE(arc_cosine(a), previous) << a;
    previous = arc_cosine(a);
  }
  EXPECT_EQ(arc_cosine(1.0F), 0.0F);
}

TEST(FpfhPair, SwapsOnlyWhenTheArcCosinesDiffer) {
  using fpfh_detail::swaps;
  EXPECT_TRUE(swaps(0.3F, 0.31F));
  EXPECT_TRUE(swaps(0.3F, -0.31F));
  EXPECT_FALSE(swaps(0.31F, 0.3F));
  EXPECT_FALSE(swaps(0.3F, -0.3F));
  EXPECT_FALSE(swaps(1e-9F, 2e-9F));  // both arc cosines round to half pi
  EXPECT_FALSE(swaps(0.5F, 1.0000001F));
  EXPECT_FALSE(swaps(kNan, 0.5F));
  EXPECT_FALSE(swaps(0.5F, kNan));
}

TEST(FpfhDispatch, TakesTheBestTier) {
  const test::Figure figure = test::standing_figure(0, 2300);
  const FigureCloud c = test::render_cloud(figure, {45, 65, 52, 52, 22, 32}, 3, 0.2, 0.1, 3);
  const std::vector<Vec3f> all = joint_keypoints(figure);
  FpfhWorkspace work(45, 65);
  std::vector<float> out(all.size() * kFpfhSize);
  fpfh(view(c), all, kFpfhRadiusMm, work, out);
  EXPECT_EQ(out, run(kFpfhWithRef[1], c, all));
}

// Every hand-written tier against portable, bit for bit.

using checkasm::Buffer;

struct Shape {
  int width, height;
  float z_mm, depth_mm;  // the nearest point, and how far behind it they scatter
  double missing, blank, coincident;
  float step_mm;  // depths and normals are multiples of something: ties and planes; 0: not
  float radius_mm;
};

// A random cloud between guard pages.
struct Cloud {
  Cloud(const Shape& shape, checkasm::Trial& trial)
      : s(shape),
        count(static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height)),
        x(count, trial.next_end()),
        y(count, trial.next_end()),
        z(count, trial.next_end()),
        nx(count, trial.next_end()),
        ny(count, trial.next_end()),
        nz(count, trial.next_end()) {
    const auto w = static_cast<float>(s.width), h = static_cast<float>(s.height);
    k = {s.width, s.height, 1.1F * w, 1.2F * w, 0.5F * w, 0.4F * h};
    for (std::size_t i = 0; i < count; ++i) fill(i, trial);
    for (std::size_t i = 1; i < count; ++i) {
      if (trial.rng().uniform() >= s.coincident || i % static_cast<std::size_t>(s.width) == 0) continue;
      // Pixels side by side may share a point between them.
      x[i] = x[i - 1], y[i] = y[i - 1], z[i] = z[i - 1];
      if (std::isnan(x[i])) continue;
      const auto u = static_cast<float>(i % static_cast<std::size_t>(s.width)) - 0.5F;
      x[i] = x[i - 1] = (u - k.cx) / k.fx * z[i];
    }
  }

  void fill(std::size_t i, checkasm::Trial& trial) {
    x[i] = y[i] = z[i] = nx[i] = ny[i] = nz[i] = kNan;
    if (trial.rng().uniform() < s.missing) return;
    float depth = s.z_mm + trial.between(0, s.depth_mm);
    if (s.step_mm > 0) depth = s.z_mm + std::floor(trial.between(0, s.depth_mm) / s.step_mm) * s.step_mm;
    const Vec3f p = unproject(k, static_cast<float>(i % static_cast<std::size_t>(s.width)),
                              static_cast<float>(i / static_cast<std::size_t>(s.width)), depth);
    x[i] = p.x, y[i] = p.y, z[i] = p.z;
    if (trial.rng().uniform() < s.blank) return;
    Vec3f n = {trial.between(-1, 1), trial.between(-1, 1), -trial.between(0.1F, 1)};
    if (s.step_mm > 0) n = {std::floor(2 * n.x), std::floor(2 * n.y), -1};
    n = normalized(n);
    nx[i] = n.x, ny[i] = n.y, nz[i] = n.z;
  }

  OrganisedCloud view() const { return {k, x.data(), y.data(), z.data(), nx.data(), ny.data(), nz.data()}; }

  Shape s;
  Intrinsics k;
  std::size_t count;
  Buffer<float> x, y, z, nx, ny, nz;
};

// Returns how many keypoints had anything in range.
int compare(const Shape& s, int keypoint_count, checkasm::Trial& trial, FpfhWorkspace& work) {
  IM2FIT_CHECK_PARAMETERS(trial, s.width << " x " << s.height << ", z " << s.z_mm << ", missing " << s.missing
                                         << ", blank " << s.blank << ", radius " << s.radius_mm);
  Cloud cloud(s, trial);
  std::vector<Vec3f> keypoints;
  for (int n = 0; n < keypoint_count; ++n) {
    const auto i = static_cast<std::size_t>(trial.rng().index(static_cast<int>(cloud.count)));
    keypoints.push_back({cloud.x[i], cloud.y[i], cloud.z[i]});  // NaN now and then
    if (n % 2 == 0) keypoints.back() = keypoints.back() + Vec3f{7, -11, 5};
  }
  Buffer<float> want(keypoints.size() * kFpfhSize, trial.next_end()), got(want.size(), trial.next_end());
  fpfh_portable(cloud.view(), keypoints, s.radius_mm, work, want.span());
  checkasm::each_simd(kFpfhKernels, [&](const auto& variant) {
    got.refill();
    variant.function(cloud.view(), keypoints, s.radius_mm, work, got.span());
    checkasm::expect_same_bits(want, got);
  });
  int described = 0;
  for (std::size_t n = 0; n < keypoints.size(); ++n) {
    const auto first = want.span().subspan(n * kFpfhSize, kFpfhSize);
    described += std::any_of(first.begin(), first.end(), [](float v) { return v > 0; }) ? 1 : 0;
  }
  return described;
}

TEST(FpfhSimd, RandomClouds) {
  checkasm::Trial trial;
  FpfhWorkspace work(64, 48);
  int described = 0;
  for (const int width : checkasm::odd_sizes(40)) {
    if (width < 3) continue;
    for (const float z : {150.0F, 900.0F}) {
      described += compare({width, 17, z, 300, 0.2, 0.1, 0.02, 0, 200}, 5, trial, work);
      described += compare({width, 13, z, 120, 0.0, 0.0, 0.0, 0, 200}, 1, trial, work);
      described += compare({width, 11, z, 300, 0.6, 0.5, 0.1, 0, 150}, 9, trial, work);
    }
  }
  EXPECT_GT(described, 200);
}

// Depths and normals of few values: coincident points, equal normals, ties of the swap rule, v = 0.
TEST(FpfhSimd, QuantisedClouds) {
  checkasm::Trial trial;
  FpfhWorkspace work(64, 48);
  for (int n = 0; n < 12; ++n) {
    EXPECT_GT(compare({29, 23, 600, 200, 0.1, 0.05, 0.1, 10, 200}, 6, trial, work), 0);
    EXPECT_GT(compare({31, 14, 300, 40, 0.0, 0.0, 0.0, 50, 200}, 3, trial, work), 0);
  }
}

// Thousands of neighbours: byte counters must be emptied in time, a source's own and the others'.
TEST(FpfhSimd, CountersDoNotOverflow) {
  checkasm::Trial trial;
  FpfhWorkspace work(300, 300);
  EXPECT_EQ(compare({299, 9, 250, 5, 0.0, 0.0, 0.0, 5, 200}, 4, trial, work), 4);
  EXPECT_GT(compare({7, 290, 250, 5, 0.05, 0.02, 0.0, 0, 400}, 4, trial, work), 0);
}

// Coordinates so small that their products are denormals, which some vector units take for zeros.
TEST(FpfhSimd, DenormalsDecideAlike) {
  checkasm::Trial trial;
  FpfhWorkspace work(16, 16);
  for (const float tiny : {1e-12F, 1e-20F, 1e-30F}) {
    Cloud cloud({9, 7, 300, 0, 0, 0, 0, 0, 200}, trial);
    for (std::size_t i = 0; i < cloud.count; ++i) {
      const Vec3f n =
          normalized({tiny * trial.between(-1, 1), i % 2 == 0 ? tiny : 1.0F, trial.between(-1, 1) * tiny});
      cloud.nx[i] = n.x, cloud.ny[i] = n.y, cloud.nz[i] = i % 2 == 0 ? -1.0F : n.z;
      if (i % 9 == 4) cloud.x[i] = tiny * trial.between(-1, 1);
    }
    const std::vector<Vec3f> keypoints = {{5, 3, 310}, {-40, 20, 290}};
    std::vector<float> want(keypoints.size() * kFpfhSize), got(want.size());
    fpfh_portable(cloud.view(), keypoints, 200, work, want);
    checkasm::each_simd(kFpfhKernels, [&](const auto& variant) {
      variant.function(cloud.view(), keypoints, 200, work, got);
      checkasm::expect_same_bits<float>(want, got);
    });
  }
}

// A workspace used before, for a larger picture: nothing of it may show.
TEST(FpfhSimd, WorkspaceIsCleanEachTime) {
  checkasm::Trial trial;
  FpfhWorkspace work(64, 48);
  const Shape small = {21, 9, 500, 100, 0.3, 0.2, 0, 0, 200}, large = {60, 40, 500, 100, 0.1, 0.1, 0, 0, 200};
  for (int n = 0; n < 3; ++n) {
    EXPECT_GT(compare(large, 3, trial, work), 0);
    EXPECT_GT(compare(small, 3, trial, work), 0);
  }
}

}  // namespace
}  // namespace im2fit
