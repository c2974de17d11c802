// SPDX-License-Identifier: Apache-2.0
#include "kernels/gram/gram.h"

#include <cmath>

#include "tests/kernels/checkasm.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit {
namespace {

using checkasm::Buffer;

TEST(AddGram, RefOnTwoRows) {
  std::vector<double> rows(2 * kGramWidth), sums(kGramWidth), products(kGramWidth * kGramWidth);
  rows[0] = 2, rows[1] = 3;
  rows[kGramWidth] = -1, rows[kGramWidth + 1] = 5;
  const double weights[] = {10, 1};
  products[kGramWidth] = 100;
  add_gram_ref(rows.data(), weights, 2, 2, sums.data(), products.data());
  EXPECT_EQ(sums[0], 19);
  EXPECT_EQ(sums[1], 35);
  EXPECT_EQ(products[0], 41);
  EXPECT_EQ(products[kGramWidth], 100 + 60 - 5);
  EXPECT_EQ(products[kGramWidth + 1], 115);
}

TEST(AddGram, EveryTierGivesTheSameSums) {
  checkasm::Trial trial;
  for (int used = 0; used <= kGramWidth; ++used) {
    for (const int count : {0, 1, 2, 7, 32}) {
      IM2FIT_CHECK_PARAMETERS(trial, used << " columns, " << count << " rows");
      constexpr std::size_t kSize = kGramWidth * kGramWidth;
      Buffer<double> rows(static_cast<std::size_t>(count * kGramWidth), trial.next_end());
      Buffer<double> weights(static_cast<std::size_t>(count), trial.next_end());
      for (std::size_t i = 0; i < rows.size(); ++i)
        rows[i] = static_cast<int>(i % kGramWidth) < used ? trial.rng().uniform(-1, 1) : 0.0;
      for (double& w : weights.span()) w = trial.rng().uniform();
      struct Result {
        Buffer<double> sums, products;
        explicit Result(checkasm::Guard end) : sums(kGramWidth, end), products(kSize, end) {
          for (double& v : sums.span()) v = 0.25;
          for (double& v : products.span()) v = 0.5;
        }
      };
      const auto run = [&](AddGramFunction* function, Result& out) {
        function(rows.data(), weights.data(), count, used, out.sums.data(), out.products.data());
      };
      Result truth(trial.next_end()), want(trial.next_end());
      run(add_gram_ref, truth);
      run(add_gram_portable, want);
      const auto compare = [&](Result& a, Result& b, double tolerance) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(used); ++i) {
          ASSERT_LE(std::abs(a.sums[i] - b.sums[i]), tolerance) << "sum " << i;
          for (std::size_t j = 0; j <= i; ++j)
            ASSERT_LE(std::abs(a.products[i * kGramWidth + j] - b.products[i * kGramWidth + j]), tolerance)
                << "product " << i << ", " << j;
        }
      };
      compare(truth, want, (count + 1) * (count + 1.0) * 0x1p-52);
    }
  }
}

}  // namespace
}  // namespace im2fit
