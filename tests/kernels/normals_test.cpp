// SPDX-License-Identifier: Apache-2.0
#include "kernels/normals/normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"
#include "tests/perception/analytic_figure.h"

namespace im2fit {
namespace {

using test::Figure;
using test::FigureCloud;

constexpr float kStepMm = 60.0F;
const double kDegree = std::acos(-1.0) / 180;

struct Normals {
  std::vector<float> x, y, z;
  Vec3f at(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

Normals run(const NormalsKernel& kernel, const FigureCloud& c, int radius, float step = kStepMm) {
  Normals n;
  for (std::vector<float>* a : {&n.x, &n.y, &n.z}) a->assign(c.x.size(), 7.0F);
  kernel.function(c.intrinsics, c.x.data(), c.y.data(), c.z.data(), radius, step, n.x.data(), n.y.data(), n.z.data());
  return n;
}

double angle(Vec3f a, Vec3f b) {
  return std::atan2(double{norm(cross(a, b))}, double{dot(a, b)});
}

class NormalsTiers : public testing::TestWithParam<NormalsKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, NormalsTiers, testing::ValuesIn(kNormalsWithRef),
                         [](const auto& p) { return std::string(p.param.name); });

TEST_P(NormalsTiers, TiltedPlaneExactly) {
  const Intrinsics k = {30, 40, 60, 70, 14, 21};
  FigureCloud c = test::render_cloud({}, k, 0, 0, 0, 0);
  const Vec3f n = normalized({0.4F, -0.3F, -1});
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const Vec3f ray = {(static_cast<float>(u) - k.cx) / k.fx, (static_cast<float>(v) - k.cy) / k.fy, 1};
      const Vec3f p = ray * (-1000.0F / dot(n, ray));  // n.p = -1000 mm
      const auto i = static_cast<std::size_t>(v * k.width + u);
      c.x[i] = p.x, c.y[i] = p.y, c.z[i] = p.z;
    }
  }
  const Normals got = run(GetParam(), c, 1);
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const auto i = static_cast<std::size_t>(v * k.width + u);
      const bool corner = (u == 0 || u == k.width - 1) && (v == 0 || v == k.height - 1);
      if (corner) {
        EXPECT_TRUE(std::isnan(got.x[i]) && std::isnan(got.y[i]) && std::isnan(got.z[i]));  // 4 of 9 only
      } else {
        ASSERT_LT(angle(got.at(i), n), 0.02 * kDegree) << u << ' ' << v;
        ASSERT_NEAR(norm(got.at(i)), 1, 1e-6F);
      }
    }
  }
}

TEST_P(NormalsTiers, SphereFromItsCentre) {
  const Intrinsics k = {90, 120, 105, 105, 44.5F, 59.5F};
  Figure figure;
  figure.ellipsoids = {{{50, -100, 2000}, {400, 400, 400}}};
  const FigureCloud c = test::render_cloud(figure, k, 0, 0, 0, 0);
  const Normals got = run(GetParam(), c, 1);
  int checked = 0;
  for (std::size_t i = 0; i < c.x.size(); ++i) {
    const Vec3f truth = {c.nx[i], c.ny[i], c.nz[i]};
    if (!(truth.z < -0.5F)) continue;  // up to 60 degrees: nearer the rim the window is not symmetric any more
    ASSERT_FALSE(std::isnan(got.x[i]));
    // A fitted plane is parallel to the surface somewhere inside its window: half a window is 19 mm of a 400 mm
    // sphere, foreshortened by n.z. Facing the camera the window is symmetric and the error of higher order.
    ASSERT_LT(angle(got.at(i), truth), 19.0 / 400 / -double{truth.z});
    if (truth.z < -0.98F) {
      ASSERT_LT(angle(got.at(i), truth), 0.5 * kDegree);
    }
    EXPECT_LT(dot(got.at(i), {c.x[i], c.y[i], c.z[i]}), 0);
    ++checked;
  }
  EXPECT_GT(checked, 800);
}

// A step deeper than max_step_mm does not tilt the normals beside it.
TEST_P(NormalsTiers, StepsAreNotBridged) {
  const Intrinsics k = {20, 20, 40, 40, 9.5F, 9.5F};
  FigureCloud c = test::render_cloud({}, k, 0, 0, 0, 0);
  for (int v = 0; v < 20; ++v) {
    for (int u = 0; u < 20; ++u) {
      const Vec3f p = unproject(k, static_cast<float>(u), static_cast<float>(v), u < 10 ? 1000.0F : 1100.0F);
      const auto i = static_cast<std::size_t>(v * 20 + u);
      c.x[i] = p.x, c.y[i] = p.y, c.z[i] = p.z;
    }
  }
  const auto beside = static_cast<std::size_t>(10 * 20 + 9);
  EXPECT_LT(angle(run(GetParam(), c, 1).at(beside), {0, 0, -1}), 0.01 * kDegree);
  EXPECT_GT(angle(run(GetParam(), c, 1, 200.0F).at(beside), {0, 0, -1}), 20 * kDegree);
}

TEST_P(NormalsTiers, NoNormalWhereThereIsNoPlane) {
  const Intrinsics k = {9, 9, 40, 40, 4, 4};
  FigureCloud c = test::render_cloud({}, k, 0, 0, 0, 0);
  Normals got = run(GetParam(), c, 1);
  for (std::size_t i = 0; i < c.x.size(); ++i) ASSERT_TRUE(std::isnan(got.x[i]));
  // Nine points of one line in space.
  for (int i = 0; i < 9; ++i) {
    const auto at = static_cast<std::size_t>((3 + i / 3) * 9 + 3 + i % 3);
    c.x[at] = static_cast<float>(i), c.y[at] = 0, c.z[at] = 1000;
  }
  got = run(GetParam(), c, 1);
  EXPECT_TRUE(std::isnan(got.x[4 * 9 + 4]));
}

TEST(NormalsPortable, AgreesWithRefOnANoisyFigure) {
  const Figure figure = test::standing_figure(0, 2300);
  const FigureCloud c = test::render_cloud(figure, {90, 130, 105, 105, 44.5F, 64.5F}, 2, 0, 0, 9);
  for (int radius : {1, 2}) {
    const Normals want = run(kNormalsWithRef[0], c, radius), got = run(kNormalsWithRef[1], c, radius);
    int checked = 0, apart = 0;
    for (std::size_t i = 0; i < c.x.size(); ++i) {
      ASSERT_EQ(std::isnan(want.x[i]), std::isnan(got.x[i]));
      if (std::isnan(want.x[i])) continue;
      ++checked;
      apart += angle(want.at(i), got.at(i)) > 1e-3 ? 1 : 0;  // two nearly equal eigenvalues leave the normal open
    }
    EXPECT_GT(checked, 900);
    EXPECT_LE(apart, checked / 200) << radius;
  }
}

// Every hand-written tier against portable, bit for bit.

using checkasm::Buffer;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Scene {
  float depth_mm;  // points scatter so far behind 900 mm; 0: a plane facing the camera
  double missing;
  float max_step_mm;
};

struct Cloud {
  Cloud(int width, int height, const Scene& scene, checkasm::Trial& trial)
      : count(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
        x(count, trial.next_end()),
        y(count, trial.next_end()),
        z(count, trial.next_end()) {
    k = {width, height, 90, 80, 0.5F * static_cast<float>(width), 0.4F * static_cast<float>(height)};
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = y[i] = z[i] = kNan;
      if (trial.rng().uniform() < scene.missing) continue;
      const Vec3f p =
          unproject(k, static_cast<float>(i % static_cast<std::size_t>(width)),
                    static_cast<float>(i / static_cast<std::size_t>(width)), 900 + trial.between(0, scene.depth_mm));
      x[i] = p.x, y[i] = p.y, z[i] = p.z;
    }
  }
  Intrinsics k;
  std::size_t count;
  Buffer<float> x, y, z;
};

// Returns how many pixels have a normal. A NaN has many bit patterns and one meaning.
int compare(int width, int height, int radius, const Scene& scene, checkasm::Trial& trial) {
  IM2FIT_CHECK_PARAMETERS(trial, width << " x " << height << ", radius " << radius << ", depth " << scene.depth_mm
                                       << ", missing " << scene.missing << ", step " << scene.max_step_mm);
  Cloud c(width, height, scene, trial);
  Buffer<float> want[3] = {Buffer<float>(c.count), Buffer<float>(c.count), Buffer<float>(c.count)};
  normals_portable(c.k, c.x.data(), c.y.data(), c.z.data(), radius, scene.max_step_mm, want[0].data(), want[1].data(),
                   want[2].data());
  checkasm::each_simd(kNormalsKernels, [&](const auto& variant) {
    Buffer<float> x(c.count, trial.next_end()), y(c.count, trial.next_end()), z(c.count, trial.next_end());
    variant.function(c.k, c.x.data(), c.y.data(), c.z.data(), radius, scene.max_step_mm, x.data(), y.data(),
                     z.data());
    for (Buffer<float>* b : {&want[0], &want[1], &want[2], &x, &y, &z}) {
      for (float& value : b->span()) value = std::isnan(value) ? kNan : value;
    }
    checkasm::expect_same_bits(want[0], x);
    checkasm::expect_same_bits(want[1], y);
    checkasm::expect_same_bits(want[2], z);
  });
  int found = 0;
  for (const float value : want[2].span()) found += std::isnan(value) ? 0 : 1;
  return found;
}

TEST(NormalsSimd, OddSizes) {
  checkasm::Trial trial;
  int found = 0;
  for (const int width : checkasm::odd_sizes(50)) {
    for (const int radius : {1, 2, 7}) {
      found += compare(width, 9, radius, {40, 0.1, 60}, trial);
      compare(width, 1, radius, {40, 0.0, 60}, trial);
      compare(width, 2 * radius + 1, radius, {120, 0.4, 60}, trial);
    }
  }
  EXPECT_GT(found, 5000);
}

// Exact planes, where sums cancel; everything on its own surface, where windows are empty but for their centre.
TEST(NormalsSimd, PlanesAndScatter) {
  checkasm::Trial trial;
  EXPECT_GT(compare(41, 31, 1, {0, 0, 60}, trial), 1000);
  EXPECT_GT(compare(41, 31, 2, {0, 0.3, 60}, trial), 700);
  EXPECT_EQ(compare(41, 31, 1, {3000, 0, 0.5F}, trial), 0);
  EXPECT_EQ(compare(41, 31, 1, {40, 1.0, 60}, trial), 0);
}

}  // namespace
}  // namespace im2fit
