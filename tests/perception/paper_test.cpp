// SPDX-License-Identifier: Apache-2.0
#include "perception/paper/paper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tests/perception/analytic_figure.h"
#include "tests/perception/paper_ref.h"

namespace im2fit {
namespace {

const double kPi = std::acos(-1.0);
struct PaperVariant {
  const char* name;
  decltype(measure_paper)* function;
};
constexpr PaperVariant kRef = {"ref", paper_ref::measure_paper_ref}, kProduct = {"product", measure_paper};

constexpr Intrinsics kPortrait = {480, 640, 525, 525, 239.5F, 319.5F};

// Depth in 1/16 mm of whatever `depth_mm` says a ray (tx, ty, 1) meets first; 0 where nothing.
struct Picture {
  Intrinsics k = kPortrait;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> mask;

  explicit Picture(const std::function<double(double, double)>& depth_mm, Intrinsics intrinsics = kPortrait)
      : k(intrinsics) {
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        const double z = depth_mm((u - double{k.cx}) / double{k.fx}, (v - double{k.cy}) / double{k.fy});
        depth.push_back(static_cast<std::uint16_t>(std::lround(z * 16)));
        mask.push_back(z > 0 ? 255 : 0);
      }
    }
  }
  PaperMeasurements measure(const PaperVariant& variant, const JointSet& joints) const {
    PaperWorkspace work(k.width, k.height);
    return variant.function({depth.data(), k.width, k.height}, {mask.data(), k.width, k.height}, k, joints, work);
  }
};

JointSet upright_joints(float z_mm) {
  return test::standing_figure(0, z_mm).joints;
}

class Paper : public testing::TestWithParam<PaperVariant> {};
INSTANTIATE_TEST_SUITE_P(Tiers, Paper, testing::Values(kRef, kProduct),
                         [](const auto& p) { return std::string(p.param.name); });

TEST(PaperBodyFrame, AxesOfAnUprightPerson) {
  const BodyFrame f = body_frame(upright_joints(2000));
  EXPECT_TRUE(f.upright);
  EXPECT_NEAR(f.lateral, 0, 1e-6);
  EXPECT_NEAR(f.u.y, 1, 1e-6);
  EXPECT_NEAR(f.v.x, -1, 1e-6);
  EXPECT_NEAR(f.w.z, 1, 1e-6);
}

TEST(PaperBodyFrame, CorrectedEquationOne) {
  struct Case {
    const char* what;
    Vec3f hips_from_torso;
    float lateral;
    bool upright;
  };
  const Case cases[] = {
      {"straight down", {0, 300, 0}, 0, true},
      {"just inside", {0.099F * 300, 0.9950874F * 300, 0}, 0.099F, true},
      {"just outside", {0, 0.9948869F * 300, 0.101F * 300}, 0.101F, false},
      {"a right angle", {300, 0, 0}, 1, false},
      {"bent double: no lateral part, but the hips are above", {0, -300, 0}, 0, false},
      {"hips on the torso", {0, 0, 0}, 1, false},
  };
  for (const Case& c : cases) {
    JointSet j = upright_joints(2000);
    const Vec3f hips = j[Joint::TO] + c.hips_from_torso;
    j[Joint::LH] = hips + Vec3f{90, 0, 0};
    j[Joint::RH] = hips - Vec3f{90, 0, 0};
    const BodyFrame f = body_frame(j);
    EXPECT_NEAR(f.lateral, c.lateral, 1e-5) << c.what;
    EXPECT_EQ(f.upright, c.upright) << c.what;
  }
}

TEST(PaperBodyFrame, DegenerateJointsHaveNoFrame) {
  for (const Vec3f broken : {Vec3f{0, -540, 2000}, Vec3f{std::nanf(""), 0, 2000}, Vec3f{0, 0, 1e30F}}) {
    JointSet j = upright_joints(2000);
    j[Joint::TO] = broken;  // on the neck, nowhere, or absurdly far
    const BodyFrame f = body_frame(j);
    EXPECT_FALSE(f.upright);
    EXPECT_EQ(norm(f.w), 0);
    for (const PaperVariant& variant : {kRef, kProduct}) {
      EXPECT_FALSE(Picture([](double, double) { return 2000.0; }).measure(variant, j).valid);
    }
  }
}

// A flat figure in a slanted plane z = 2000 + 0.2 y: rows v0..v1 of a column strip. Distances follow from the
// pinhole.
TEST_P(Paper, StatureOfACardboardFigure) {
  const double slant = 0.2;
  const double row_top = (40 - 319.5) / 525, row_bottom = (560 - 319.5) / 525, half = 30.5 / 525;
  const Picture picture([&](double tx, double ty) {
    const bool inside = std::fabs(tx) < half && ty > row_top - 1e-6 && ty < row_bottom + 1e-6;
    return inside ? 2000 / (1 - slant * ty) : 0.0;
  });
  const double z0 = 2000 / (1 - slant * row_top), z1 = 2000 / (1 - slant * row_bottom);
  const double truth = std::hypot(z1 * row_bottom - z0 * row_top, z1 - z0);
  JointSet j = upright_joints(2000);
  const PaperMeasurements m = picture.measure(GetParam(), j);
  ASSERT_TRUE(m.valid);
  EXPECT_NEAR(m.stature_mm, truth, 0.1);  // depth is rounded to 1/16 mm
}

// The contour away from the axis does not count: a raised hand beside the head is not the crown.
TEST_P(Paper, StatureIgnoresARaisedHand) {
  const Picture picture([](double tx, double ty) {
    const bool trunk = std::fabs(tx) < 0.06 && ty > -0.4 && ty < 0.45;
    const bool hand = std::fabs(tx - 0.2) < 0.02 && ty > -0.55 && ty < 0;
    return trunk || hand ? 2000.0 : 0.0;
  });
  const PaperMeasurements m = picture.measure(GetParam(), upright_joints(2000));
  ASSERT_TRUE(m.valid);
  EXPECT_NEAR(m.stature_mm, 1700, 2 * 2000.0 / 525);  // a pixel at either end
}

TEST_P(Paper, LengthsAreSumsOfJointDistances) {
  JointSet j = upright_joints(2000);
  j[Joint::NE] = {0, -500, 2000}, j[Joint::LS] = {200, -500, 2000}, j[Joint::RS] = {-200, -500, 2000};
  j[Joint::LE] = {200, -200, 2000}, j[Joint::LA] = {200, -200, 1750};    // 200 + 300 + 250
  j[Joint::RE] = {-600, -500, 2000}, j[Joint::RA] = {-600, -230, 2000};  // 200 + 400 + 270
  j[Joint::LH] = {100, 50, 2000}, j[Joint::LK] = {100, 450, 2000}, j[Joint::LF] = {100, 450, 2400};     // 800
  j[Joint::RH] = {-100, 50, 2000}, j[Joint::RK] = {-100, 450, 2000}, j[Joint::RF] = {-400, 850, 2000};  // 900
  const Picture picture(
      [](double tx, double ty) { return std::fabs(tx) < 0.08 && std::fabs(ty) < 0.4 ? 2000.0 : 0.0; });
  const PaperMeasurements m = picture.measure(GetParam(), j);
  EXPECT_NEAR(m.sleeve_mm, (750 + 870) / 2.0, 0.01);
  EXPECT_NEAR(m.leg_mm, 850, 0.01);
  EXPECT_NEAR(m.shoulder_mm, 400, 0.01);
  const MeasurementValues values = to_values(m);
  EXPECT_EQ(values[measurement_index(Measurement::sleeve_length)], m.sleeve_mm);
  EXPECT_EQ(values[measurement_index(Measurement::shoulder_breadth)], m.shoulder_mm);
  EXPECT_EQ(values[measurement_index(Measurement::stature)], m.stature_mm);
  EXPECT_TRUE(std::isnan(values[measurement_index(Measurement::weight)]));
  EXPECT_TRUE(std::isnan(values[measurement_index(Measurement::inside_leg)]));
}

// Where the ray (tx, ., 1) enters the upright elliptic cylinder of half-axes a (sideways) and b about (x, z).
double cylinder_depth(double tx, double x, double z, double a, double b) {
  const double qa = tx * tx / (a * a) + 1 / (b * b), qb = tx * x / (a * a) + z / (b * b),
               qc = x * x / (a * a) + z * z / (b * b) - 1;
  const double disc = qb * qb - qa * qc;
  return disc > 0 ? (qb - std::sqrt(disc)) / qa : 0;
}

double ellipse_length(double a, double b) {
  double length = 0;
  for (int i = 0; i < 2000; ++i) {
    const double t = 2 * kPi * (i + 0.5) / 2000;
    length += std::hypot(a * std::sin(t), b * std::cos(t)) * 2 * kPi / 2000;
  }
  return length;
}

JointSet column_joints(float z) {
  JointSet j = upright_joints(z);
  j[Joint::HE] = {0, -800, z}, j[Joint::NE] = {0, -560, z}, j[Joint::TO] = {0, -150, z};
  j[Joint::LS] = {150, -600, z}, j[Joint::RS] = {-150, -600, z};
  j[Joint::LH] = {90, 200, z}, j[Joint::RH] = {-90, 200, z};
  return j;
}

TEST_P(Paper, GirthsOfAnEllipticColumn) {
  const double a = 170, b = 115, z = 2200;
  const auto column = [&](double tx, double ty) { return std::fabs(ty) < 0.5 ? cylinder_depth(tx, 0, z, a, b) : 0; };
  // Arms 40 mm off: they must not join.
  const auto with_arms = [&](double tx, double ty) {
    const double trunk = column(tx, ty);
    if (trunk > 0 || std::fabs(ty) >= 0.5) return trunk;
    return std::max(cylinder_depth(tx, 255, z, 45, 45), cylinder_depth(tx, -255, z, 45, 45));
  };
  const double truth = ellipse_length(a, b);
  for (const Picture& picture : {Picture(column), Picture(with_arms)}) {
    const PaperMeasurements m = picture.measure(GetParam(), column_joints(static_cast<float>(z)));
    ASSERT_TRUE(m.valid);
    // The band is up to a tenth of the distance thick, but an upright column is the same all along.
    for (const float girth : {m.neck_mm, m.shoulder_girth_mm, m.chest_mm, m.waist_mm, m.hip_mm}) {
      EXPECT_NEAR(girth, truth, 1.0);
    }
    EXPECT_NEAR(m.hip_waist_ratio, 1, 2e-3);
  }
}

TEST_P(Paper, AFlatSectionHasNoEllipse) {
  const Picture picture(
      [](double tx, double ty) { return std::fabs(tx) < 0.08 && std::fabs(ty) < 0.45 ? 2000.0 : 0.0; });
  const PaperMeasurements m = picture.measure(GetParam(), column_joints(2000));
  EXPECT_TRUE(m.valid);
  EXPECT_TRUE(std::isnan(m.waist_mm));
  EXPECT_TRUE(std::isnan(m.hip_waist_ratio));
  EXPECT_GT(m.stature_mm, 1500);
}

TEST_P(Paper, ChestRatioOfARoundColumn) {
  const double radius = 200, z = 2200, alpha = kPi / 3;
  const Picture picture(
      [&](double tx, double ty) { return std::fabs(ty) < 0.5 ? cylinder_depth(tx, 0, z, radius, radius) : 0; });
  JointSet j = column_joints(static_cast<float>(z));
  const auto x = static_cast<float>(radius * std::sin(alpha)),
             front = static_cast<float>(z - radius * std::cos(alpha));
  j[Joint::LS] = {x, -500, front}, j[Joint::RS] = {-x, -500, front};
  // Either end is found to half a pixel: 2 mm, along the steep flank 4 mm of an arc of 419.
  EXPECT_NEAR(picture.measure(GetParam(), j).chest_ratio, alpha / std::sin(alpha), 0.015);
  // Shoulders beyond the column: the surface between them was not seen.
  j[Joint::LS].x = 500, j[Joint::RS].x = -500;
  EXPECT_TRUE(std::isnan(picture.measure(GetParam(), j).chest_ratio));
}

TEST_P(Paper, NothingSeen) {
  Picture picture([](double, double) { return 0.0; });
  const PaperMeasurements m = picture.measure(GetParam(), upright_joints(2000));
  EXPECT_FALSE(m.valid);
  for (const float value : to_values(m)) EXPECT_TRUE(std::isnan(value));
}

// The whole figure with noise, off centre and against a border: the contract's tolerances.
TEST(PaperPortable, AgreesWithRef) {
  for (const float x : {0.0F, -300.0F, 750.0F}) {
    const test::Figure figure = test::standing_figure(x, 2250);
    Rng rng(17);
    const Picture picture([&](double tx, double ty) {
      const test::Hit hit = figure.cast_ray(tx, ty);
      return hit.z > 0 ? hit.z + rng.normal(0, 2) : 0;
    });
    JointSet j = figure.joints;
    j[Joint::LS] = j[Joint::LS] + Vec3f{5, -8, 12};  // the frame's axes are not the picture's
    const PaperMeasurements ref = picture.measure(kRef, j), got = picture.measure(kProduct, j);
    ASSERT_TRUE(ref.valid && got.valid);
    EXPECT_NEAR(got.stature_mm, ref.stature_mm, 0.05);
    EXPECT_NEAR(got.sleeve_mm, ref.sleeve_mm, 0.05);
    EXPECT_NEAR(got.leg_mm, ref.leg_mm, 0.05);
    EXPECT_NEAR(got.neck_mm, ref.neck_mm, 1);
    EXPECT_NEAR(got.shoulder_girth_mm, ref.shoulder_girth_mm, 1);
    EXPECT_NEAR(got.chest_mm, ref.chest_mm, 1);
    EXPECT_NEAR(got.waist_mm, ref.waist_mm, 1);
    EXPECT_NEAR(got.hip_mm, ref.hip_mm, 1);
    if (x == 0) {
      // Crown -830, soles about +900 of the figure, both seen from the trunk's height.
      EXPECT_NEAR(ref.stature_mm, 1730, 40);
    }
  }
}

}  // namespace
}  // namespace im2fit
