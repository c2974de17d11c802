// SPDX-License-Identifier: Apache-2.0
#include "train/index/moments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/rng.h"
#include "train/index/densify.h"

namespace im2fit::index {
namespace {

constexpr int kFeatures = 37, kTargets = 3;
struct Row {
  std::vector<float> z;
  Eigen::VectorXd y;
  int fold = 0;
};

std::vector<Row> rows(std::size_t count) {
  Rng rng(4);
  std::vector<Row> out(count);
  for (Row& r : out) {
    for (int i = 0; i < kFeatures; ++i) r.z.push_back(static_cast<float>((rng.index(40961) - 20480) / 4096.0));
    r.y = Eigen::VectorXd::NullaryExpr(kTargets, [&] { return rounded_target(rng.normal(0, 2)); });
    r.fold = rng.index(2);
  }
  return out;
}

std::vector<Moments> sums_of(const std::vector<Row>& rows, std::size_t first, std::size_t last) {
  FoldMoments moments(kFeatures, kTargets, 2);
  for (std::size_t i = first; i < last; ++i) moments.add(rows[i].fold, rows[i].z, rows[i].y);
  return moments.folds();
}

bool same(const Moments& a, const Moments& b) {
  return a.count == b.count && a.cross == b.cross && a.feature_sum == b.feature_sum && a.target_sum == b.target_sum &&
         Eigen::MatrixXd(a.gram.triangularView<Eigen::Lower>()) ==
             Eigen::MatrixXd(b.gram.triangularView<Eigen::Lower>());
}

TEST(Moments, AreTheSameBitsInAnyOrderAndAnyParts) {
  auto all = rows(1000);
  const auto whole = sums_of(all, 0, all.size());
  auto parts = sums_of(all, 0, 311);
  for (const auto& [first, last] : {std::pair(701, 1000), std::pair(311, 701)}) {
    const auto part = sums_of(all, static_cast<std::size_t>(first), static_cast<std::size_t>(last));
    for (std::size_t f = 0; f < 2; ++f) parts[f] += part[f];
  }
  std::reverse(all.begin(), all.end());
  const auto reversed = sums_of(all, 0, all.size());
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_TRUE(same(whole[f], parts[f]));
    EXPECT_TRUE(same(whole[f], reversed[f]));
  }
}

// In integers of 64 bits, which the largest sums allowed would also fit.
TEST(Moments, AreTheSumsTheySay) {
  const auto all = rows(300);
  const auto sums = sums_of(all, 0, all.size());
  for (int i = 0; i < kFeatures; ++i)
    for (int j = 0; j <= i; ++j) {
      std::int64_t sum = 0;
      for (const Row& r : all)
        if (r.fold == 1)
          sum += static_cast<std::int64_t>(r.z[static_cast<std::size_t>(i)] * 4096) *
                 static_cast<std::int64_t>(r.z[static_cast<std::size_t>(j)] * 4096);
      ASSERT_EQ(sums[1].gram(i, j), static_cast<double>(sum) / 4096 / 4096);
    }
  double count = 0;
  for (const Row& r : all) count += r.fold;
  EXPECT_EQ(sums[1].count, count);
}

TEST(Moments, TargetsKeepToTheirGrid) {
  EXPECT_EQ(rounded_target(0.3), 307.0 / 1024);
  EXPECT_EQ(rounded_target(-99), -16);
}

TEST(Densifier, MixesTwoOfOneSexAndKeepsTheSpread) {
  std::array<std::vector<std::uint32_t>, 2> of_sex;
  for (std::uint32_t i = 0; i < 400; ++i) of_sex[i % 3 == 0 ? 1 : 0].push_back(i);
  std::vector<double> value(400);
  Rng rng(6);
  for (auto& v : value) v = rng.normal();
  const Densifier densifier(of_sex, 11);
  double square = 0, all = 0;
  for (const double v : value) all += v * v / 400;
  for (std::uint64_t n = 0; n < 20000; ++n) {
    const Mix mix = densifier.mix(n);
    ASSERT_NE(mix.first, mix.second);
    ASSERT_EQ(mix.first % 3 == 0, mix.second % 3 == 0);
    ASSERT_NEAR(mix.first_share * mix.first_share + mix.second_share * mix.second_share, 1, 1e-12);
    ASSERT_GE(mix.first_share, mix.second_share);
    const double v = mix.first_share * value[mix.first] + mix.second_share * value[mix.second];
    square += v * v / 20000;
  }
  EXPECT_NEAR(square, all, 0.05 * all);
  EXPECT_EQ(densifier.mix(5).first, Densifier(of_sex, 11).mix(5).first);
}

}  // namespace
}  // namespace im2fit::index
