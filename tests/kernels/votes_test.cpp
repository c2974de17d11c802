// SPDX-License-Identifier: Apache-2.0
#include "kernels/votes/votes.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

class VotesTiers : public testing::TestWithParam<VotesKernel> {};
INSTANTIATE_TEST_SUITE_P(Tiers, VotesTiers, testing::ValuesIn(kVotesWithRef),
                         [](const auto& p) { return std::string(p.param.name); });

// The plane z = 2000: q = (0, 0, -1/2000) meets every ray there.
TEST_P(VotesTiers, CountsByDistanceFromTheWall) {
  if (!tier_available(GetParam().tier)) GTEST_SKIP() << "not on this machine";
  const std::vector<float> z = {1969, 1971, 2000, 2029, 2031, 2089, 2091, 9000, 500};
  const std::vector<float> ray(z.size(), 0.3F), near(z.size(), 30), far(z.size(), 10);
  const VotingPoints points = {ray.data(), ray.data(), z.data(), near.data(), far.data(), static_cast<int>(z.size())};
  const float wall[3] = {0, 0, -1.0F / 2000}, none[3] = {0, 0, 1.0F / 2000};
  Votes got;
  GetParam().function(points, wall, got);
  EXPECT_EQ(got.on, 3);
  EXPECT_EQ(got.behind, 2);
  GetParam().function(points, none, got);  // behind the camera
  EXPECT_EQ(got.on, 0);
  EXPECT_EQ(got.behind, 0);
}

TEST(VotesCheck, EveryTierGivesTheSameCounts) {
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
        Votes ref, want;
        votes_ref(points, plane, ref);
        votes_portable(points, plane, want);
        EXPECT_EQ(want.on, ref.on);  // no point of these lies on an edge
        EXPECT_EQ(want.behind, ref.behind);
      }
    }
  }
}

}  // namespace
}  // namespace im2fit
