// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "perception/paper/plan.h"
#include "tests/kernels/checkasm.h"

namespace im2fit::paper_detail {
namespace {

struct Line {
  checkasm::Buffer<std::int32_t> x, y, z;
  explicit Line(int count, checkasm::Trial& trial)
      : x(static_cast<std::size_t>(count), trial.next_end()),
        y(x.size(), trial.next_end()),
        z(x.size(), trial.next_end()) {}
  std::uint32_t length() const { return geodesic(x.data(), y.data(), z.data(), static_cast<int>(x.size())); }
  // In double; the parts of a step saturate.
  double length_in_double() const {
    double sum = 0;
    for (std::size_t i = 1; i < x.size(); ++i) {
      const auto part = [i](const checkasm::Buffer<std::int32_t>& a) {
        return std::fmin(std::fmax(double{1} * a.data()[i] - a.data()[i - 1], -32768), 32767);
      };
      sum += std::sqrt(part(x) * part(x) + part(y) * part(y) + part(z) * part(z));
    }
    return sum;
  }
};

TEST(Geodesic, IsWithinHalfAUnitAStepOfDouble) {
  checkasm::Trial trial;
  for (const int count : checkasm::odd_sizes(80)) {
    IM2FIT_CHECK_PARAMETERS(trial, count);
    Line line(count, trial);
    // Steps of all sizes, those that saturate among them.
    for (const int most : {1 << 30, 1 << 18, 1 << 14, 64, 8, 0}) {
      for (auto* a : {&line.x, &line.y, &line.z}) trial.fill(a->span(), -most, most);
      EXPECT_NEAR(line.length(), line.length_in_double(), 0.5 * count);
    }
    if (HasFailure()) return;
  }
}

// Every root where rounding turns: squares r (r + 1) round to r, one more to r + 1.
TEST(Geodesic, RootsAtTheirHalves) {
  checkasm::Trial trial;
  Line line(9, trial);
  const auto step_to = [&](std::int32_t dx, std::int32_t dy, std::int32_t dz) {
    for (std::size_t i = 0; i < 9; ++i) {
      line.x[i] = i % 2 == 0 ? 0 : dx;
      line.y[i] = i % 2 == 0 ? 0 : dy;
      line.z[i] = i % 2 == 0 ? 0 : dz;
    }
  };
  for (std::int32_t r = 1; r < 32768; r += r < 300 ? 1 : 97) {
    // Parts whose squares' sum lies about r (r + 1): r^2 + b^2 + c^2 with b^2 + c^2 about r.
    const auto b = static_cast<std::int32_t>(std::sqrt(r));
    for (std::int32_t c = 0; c * c <= r - b * b + 2 * b + 2; ++c) {
      step_to(r, b, c);
      const std::int64_t square = std::int64_t{r} * r + b * b + c * c;
      const std::uint32_t one = static_cast<std::uint32_t>(square > std::int64_t{r} * (r + 1) ? r + 1 : r);
      ASSERT_LE(square, std::int64_t{r + 1} * (r + 2));
      ASSERT_EQ(line.length(), 8 * one) << r << ' ' << b << ' ' << c;
    }
  }
  step_to(32767, -32768, 32767);
  // Back, 32768 saturates at 32767.
  EXPECT_NEAR(line.length(), 8 * std::sqrt(3.0) * 32767.5, 8);
}

TEST(Geodesic, FewerThanTwoPoints) {
  const std::int32_t one = 5;
  EXPECT_EQ(geodesic(&one, &one, &one, 1), 0U);
  EXPECT_EQ(geodesic(nullptr, nullptr, nullptr, 0), 0U);
}

double surface_length(int count, const std::function<void(double, double*)>& at) {
  std::vector<std::int32_t> a[3];
  for (int i = 0; i < count; ++i) {
    double p[3];
    at(static_cast<double>(i) / (count - 1), p);
    for (int axis = 0; axis < 3; ++axis) a[axis].push_back(static_cast<std::int32_t>(std::lround(p[axis] * 128)));
  }
  return geodesic(a[0].data(), a[1].data(), a[2].data(), count) / 128.0;
}

// Half a turn about a cylinder, climbing: sqrt((pi r)^2 + climb^2). A chord is short of its arc by 1 - (step/r)^2/24.
TEST(Geodesic, HelixOnACylinder) {
  const double pi = std::acos(-1.0), radius = 150, climb = 300, truth = std::hypot(pi * radius, climb);
  for (const int count : {25, 101, 401}) {
    const double step = pi / (count - 1);
    const double length = surface_length(count, [&](double t, double* p) {
      p[0] = radius * std::cos(pi * t), p[1] = climb * t - 400, p[2] = 2200 - radius * std::sin(pi * t);
    });
    // A root's rounding is 0.0023 mm rms, that of the points cancels between neighbours: four deviations of the
    // sum.
    EXPECT_NEAR(length, truth, truth * step * step / 24 + 4 * 0.004 * std::sqrt(count)) << count;
  }
}

// A great circle between two points of a sphere, one radian apart.
TEST(Geodesic, GreatCircleOnASphere) {
  const double radius = 500;
  const double length = surface_length(201, [&](double t, double* p) {
    // In the plane spanned by (2, 1, 2) / 3 and (1, 2, -2) / 3.
    const double c = radius * std::cos(t) / 3, s = radius * std::sin(t) / 3;
    p[0] = 2 * c + s, p[1] = c + 2 * s, p[2] = 2000 + 2 * c - 2 * s;
  });
  EXPECT_NEAR(length, radius, 4 * 0.004 * std::sqrt(201.0) + 0.001);
}

// A straight line, finely cut: rounding down each root would lose 0.004 mm a step, 8 mm here.
TEST(Geodesic, FineCutsLoseNoLength) {
  const double truth = std::sqrt(3.0) * 700;
  const double length =
      surface_length(2001, [](double t, double* p) { p[0] = p[1] = 700 * t, p[2] = 1500 + 700 * t; });
  EXPECT_NEAR(length, truth, 0.5);
}

}  // namespace
}  // namespace im2fit::paper_detail
