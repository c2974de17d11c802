// SPDX-License-Identifier: Apache-2.0
#include "kernels/normals/normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

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

}  // namespace
}  // namespace im2fit
