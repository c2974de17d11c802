// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/rng.h"
#include "perception/paper/ellipse.h"
#include "tests/kernels/checkasm.h"
#include "tests/perception/paper_ref.h"

namespace im2fit {
namespace {

using paper_ref::fit_ellipse_ref;
using paper_ref::Point2;

const double kPi = std::acos(-1.0);

struct Arc {
  double a, b, turn, x, y, from, to;
};

std::vector<Point2> arc_points(const Arc& arc, int count, double noise, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Point2> points;
  for (int i = 0; i < count; ++i) {
    const double angle = arc.from + (arc.to - arc.from) * i / (count - 1);
    const double r = 1 + rng.normal(0, noise) / arc.b;
    const double px = arc.a * std::cos(angle) * r, py = arc.b * std::sin(angle) * r;
    points.push_back({arc.x + px * std::cos(arc.turn) - py * std::sin(arc.turn),
                      arc.y + px * std::sin(arc.turn) + py * std::cos(arc.turn)});
  }
  return points;
}

Ellipse fit_rounded(const std::vector<Point2>& points) {
  std::vector<SectionPoint> rounded;
  for (const Point2& p : points)
    rounded.push_back({static_cast<std::int16_t>(std::lround(p.x)), static_cast<std::int16_t>(std::lround(p.y))});
  EllipseSums sums;
  moments(rounded.data(), static_cast<int>(rounded.size()), -kSectionCoordinateMax, kSectionCoordinateMax,
          sums.sum.data());
  return fit_ellipse(sums);
}

// Coordinates in 1/8 mm: a trunk of 170 x 115 mm half-axes.
TEST(EllipseFit, WholeEllipses) {
  for (const Arc& arc : {Arc{1360, 920, 0, 0, 900, 0, 2 * kPi}, Arc{1360, 920, 0.7, -200, 800, 0, 2 * kPi},
                         Arc{500, 499, 0, 30, 20, 0, 2 * kPi}, Arc{3000, 200, -0.4, 0, 0, 0, 2 * kPi}}) {
    const std::vector<Point2> points = arc_points(arc, 400, 0, 1);
    const Ellipse ref = fit_ellipse_ref(points);
    ASSERT_TRUE(ref.valid);
    EXPECT_NEAR(ref.a, arc.a, 1e-6 * arc.a);
    EXPECT_NEAR(ref.b, arc.b, 1e-6 * arc.b);
    // Rounding to whole coordinates: 0.3 rms over 400 points.
    const Ellipse got = fit_rounded(points);
    ASSERT_TRUE(got.valid);
    EXPECT_NEAR(got.a, arc.a, 0.3);
    EXPECT_NEAR(got.b, arc.b, 0.3);
  }
}

// What a camera sees: the front half. Without noise it determines the ellipse.
TEST(EllipseFit, HalfEllipses) {
  const Arc front = {1360, 920, 0.05, 40, 900, -kPi + 0.1, -0.1};
  const std::vector<Point2> points = arc_points(front, 300, 0, 1);
  const Ellipse ref = fit_ellipse_ref(points), got = fit_rounded(points);
  ASSERT_TRUE(ref.valid && got.valid);
  EXPECT_NEAR(ref.a, 1360, 1e-3);
  EXPECT_NEAR(ref.b, 920, 1e-3);
  EXPECT_NEAR(got.a, 1360, 1.0);
  EXPECT_NEAR(got.b, 920, 1.0);
}

TEST(EllipseFit, TiersAgreeUnderNoise) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    std::vector<Point2> points = arc_points({1360, 920, 0.05, 40, 900, -kPi, 0}, 300, 24, seed);
    for (Point2& p : points) p = {std::round(p.x), std::round(p.y)};
    const Ellipse ref = fit_ellipse_ref(points), got = fit_rounded(points);
    ASSERT_TRUE(ref.valid && got.valid);
    EXPECT_NEAR(got.perimeter(), ref.perimeter(), 1e-6 * ref.perimeter());
  }
}

TEST(EllipseFit, NoEllipse) {
  std::vector<Point2> line, few;
  for (int i = 0; i < 50; ++i) line.push_back({10.0 * i, 7.0 * i + 3});
  EXPECT_FALSE(fit_ellipse_ref(line).valid);
  EXPECT_FALSE(fit_rounded(line).valid);
  few = arc_points({1000, 500, 0, 0, 0, 0, 2 * kPi}, kEllipsePointsMin - 1, 0, 1);
  EXPECT_FALSE(fit_ellipse_ref(few).valid);
  EXPECT_FALSE(fit_rounded(few).valid);
  EXPECT_FALSE(fit_rounded(std::vector<Point2>(100, {5, 5})).valid);
  EXPECT_FALSE(fit_rounded({}).valid);
}

// Girths of sections as the camera sees them, against the complete elliptic integral (by quadrature).
TEST(EllipseFit, GirthsOfSections) {
  const auto girth = [](double a, double b) {
    double length = 0;
    for (int i = 0; i < 4000; ++i) {
      const double t = 2 * kPi * (i + 0.5) / 4000;
      length += std::hypot(a * std::sin(t), b * std::cos(t)) * 2 * kPi / 4000;
    }
    return length;
  };
  for (const Arc& arc : {Arc{1360, 920, 0, 10, 30, -kPi + 0.1, -0.1}, Arc{1000, 1000, 0, 0, 0, -kPi, 0},
                         Arc{560, 500, 0.3, -40, 0, -kPi, 0}, Arc{1600, 900, -0.1, 0, -200, -kPi + 0.2, -0.2}}) {
    const Ellipse got = fit_rounded(arc_points(arc, 400, 0, 1));
    ASSERT_TRUE(got.valid);
    EXPECT_NEAR(got.perimeter(), girth(arc.a, arc.b), 8) << arc.a;  // 1 mm
  }
}

TEST(EllipsePerimeter, AgainstQuadrature) {
  for (const double b : {1.0, 0.7, 0.4, 0.1}) {
    const int n = 4000;
    double length = 0;
    for (int i = 0; i < n; ++i) {
      const double t = 2 * kPi * (i + 0.5) / n;
      length += std::hypot(std::sin(t), b * std::cos(t)) * 2 * kPi / n;
    }
    EXPECT_NEAR((Ellipse{true, 1, b}).perimeter(), length, (b < 0.3 ? 4e-4 : 1e-6) * length);
  }
}

using Sums = std::vector<std::int64_t>;

Sums sums_of(const SectionPoint* points, int count, int first_x, int last_x,
             checkasm::Guard guard = checkasm::Guard::after) {
  checkasm::Buffer<std::int64_t> sums(kMomentCount, guard);
  moments(points, count, first_x, last_x, sums.data());
  return {sums.data(), sums.data() + kMomentCount};
}

// One power after the other, in whole numbers: a double holds no 2^63.
Sums sums_term_by_term(const SectionPoint* points, int count, int first_x, int last_x) {
  Sums sums(kMomentCount);
  for (int degree = 0; degree <= 4; ++degree) {
    for (int j = 0; j <= degree; ++j) {
      for (int n = 0; n < count; ++n) {
        if (points[n].x < first_x || points[n].x > last_x) continue;
        std::int64_t term = 1;
        for (int i = 0; i < degree - j; ++i) term *= points[n].x;
        for (int i = 0; i < j; ++i) term *= points[n].y;
        sums[static_cast<std::size_t>(moment_index(degree - j, j))] += term;
      }
    }
  }
  return sums;
}

void expect_exact(const SectionPoint* points, int count, int first_x, int last_x, checkasm::Trial& trial) {
  EXPECT_EQ(sums_of(points, count, first_x, last_x, trial.next_end()),
            sums_term_by_term(points, count, first_x, last_x));
}

TEST(Moments, AreExact) {
  checkasm::Trial trial;
  std::vector<int> counts = checkasm::odd_sizes(70);
  for (const int blocks : {255, 256, 257, 511, 512, 513, 1025, 2000}) counts.push_back(blocks);
  counts.push_back(0);
  for (const int count : counts) {
    IM2FIT_CHECK_PARAMETERS(trial, count);
    checkasm::Buffer<SectionPoint> points(static_cast<std::size_t>(count), trial.next_end());
    for (SectionPoint& p : points.span())
      p = {trial.biased<std::int16_t>(-4095, 4095), trial.biased<std::int16_t>(-4095, 4095)};
    expect_exact(points.data(), count, -4095, 4095, trial);
    expect_exact(points.data(), count, trial.biased(-4096, 4095), trial.biased(-4096, 4095), trial);
    expect_exact(points.data(), count, -1000000, 1000000, trial);
    expect_exact(points.data(), count, 100, 4096, trial);
    if (HasFailure()) return;
  }
}

// As many points as there may be, all at one corner: the sum of x^4 is 32767 * 4095^4, just below 2^63.
TEST(Moments, LargestSums) {
  checkasm::Trial trial;
  for (const int sx : {-4095, 4095}) {
    for (const int sy : {-4095, 4095}) {
      const std::vector<SectionPoint> points(kMomentPointsMax,
                                             {static_cast<std::int16_t>(sx), static_cast<std::int16_t>(sy)});
      expect_exact(points.data(), kMomentPointsMax, -4095, 4095, trial);
      const Sums sums = sums_of(points.data(), kMomentPointsMax, -4095, 4095);
      EXPECT_EQ(sums[moment_index(4, 0)], std::int64_t{32767} * 4095 * 4095 * 4095 * 4095);
      EXPECT_EQ(sums[moment_index(1, 3)], std::int64_t{32767} * sx * sy * 4095 * 4095);
    }
  }
}

// Whole numbers 1 .. n on a line: Faulhaber's formulas.
TEST(Moments, PowerSums) {
  constexpr std::int64_t n = 1000;
  std::vector<SectionPoint> points;
  for (int i = 1; i <= n; ++i) points.push_back({static_cast<std::int16_t>(i), static_cast<std::int16_t>(-i)});
  const Sums s = sums_of(points.data(), n, 1, n);
  EXPECT_EQ(s[moment_index(0, 0)], n);
  EXPECT_EQ(s[moment_index(0, 1)], -n * (n + 1) / 2);
  EXPECT_EQ(s[moment_index(1, 1)], -n * (n + 1) * (2 * n + 1) / 6);
  EXPECT_EQ(s[moment_index(2, 1)], -(n * (n + 1) / 2) * (n * (n + 1) / 2));
  EXPECT_EQ(s[moment_index(2, 2)], n * (n + 1) * (2 * n + 1) * (3 * n * n + 3 * n - 1) / 30);
}

}  // namespace
}  // namespace im2fit
