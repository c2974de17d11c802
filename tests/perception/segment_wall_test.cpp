// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "perception/segment/wall.h"
#include "tests/kernels/checkasm.h"

namespace im2fit::segment {
namespace {

// The plane z = 2000: q = (0, 0, -1/2000) meets every ray there.
TEST(Votes, CountByDistanceFromTheWall) {
  const std::vector<float> z = {1969, 1971, 2000, 2029, 2031, 2089, 2091, 9000, 500};
  const std::vector<float> ray(z.size(), 0.3F), near(z.size(), 30), far(z.size(), 10);
  const VotingPoints points = {ray.data(), ray.data(), z.data(), near.data(), far.data(), static_cast<int>(z.size())};
  const float wall[3] = {0, 0, -1.0F / 2000}, none[3] = {0, 0, 1.0F / 2000};
  Votes got = count_votes(points, wall);
  EXPECT_EQ(got.on, 3);
  EXPECT_EQ(got.behind, 2);
  got = count_votes(points, none);  // behind the camera
  EXPECT_EQ(got.on, 0);
  EXPECT_EQ(got.behind, 0);
}

Votes count_in_double(const VotingPoints& points, const float* q) {
  Votes out;
  for (int i = 0; i < points.count; ++i) {
    const double inverse = -(double{q[0]} * points.ray_x[i] + double{q[1]} * points.ray_y[i] + double{q[2]});
    if (!(inverse > 1e-5)) continue;
    const double plane = 1 / inverse, z = points.z_mm[i];
    if (std::fabs(z - plane) < points.near_mm[i]) ++out.on;
    if (z > plane + 80 + points.far_mm[i]) ++out.behind;
  }
  return out;
}

TEST(Votes, AreThoseCountedInDouble) {
  checkasm::Trial trial;
  for (int count : checkasm::odd_sizes(70)) {
    IM2FIT_CHECK_PARAMETERS(trial, count);
    const auto size = static_cast<std::size_t>(count);
    checkasm::Buffer<float> x(size, trial.next_end()), y(size, trial.next_end()), z(size, trial.next_end()),
        near(size, trial.next_end()), far(size, trial.next_end());
    trial.fill(x.span(), -0.6F, 0.6F);
    trial.fill(y.span(), -0.5F, 0.5F);
    trial.fill(z.span(), 1800.0F, 2200.0F);
    trial.fill(near.span(), 20.0F, 40.0F);
    trial.fill(far.span(), 0.0F, 40.0F);
    const VotingPoints points = {x.data(), y.data(), z.data(), near.data(), far.data(), count};
    for (int repeat = 0; repeat < 8; ++repeat) {
      const float q[3] = {trial.between(-2e-4F, 2e-4F), trial.between(-2e-4F, 2e-4F),
                          -1.0F / trial.between(1500, 2500)};
      const float behind_camera[3] = {q[0] * 40, q[1] * 40, -q[2]};
      for (const float* plane : {q, behind_camera}) {
        const Votes got = count_votes(points, plane), want = count_in_double(points, plane);
        EXPECT_EQ(got.on, want.on);  // no point of these lies on an edge
        EXPECT_EQ(got.behind, want.behind);
      }
    }
  }
}

}  // namespace
}  // namespace im2fit::segment
