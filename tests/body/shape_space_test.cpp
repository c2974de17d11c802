// SPDX-License-Identifier: Apache-2.0
// The shape space as synth builds it from a few people.
#include <gtest/gtest.h>

#include <cmath>

#include "body_pack.h"
#include "train/population/shape_space_builder.h"

namespace im2fit::body {
namespace {

lab::ShapeSpaceOptions few(int threads) {
  lab::ShapeSpaceOptions options;
  options.people = 24;
  options.points = 300;
  options.shapes = 6;
  options.threads = threads;
  return options;
}

TEST(ShapeSpaceBuilder, ThreadsDoNotShow) {
  IM2FIT_NEEDS_BODY();
  const ShapeSpace one = lab::build_shape_space(*real_body(), few(1));
  const ShapeSpace three = lab::build_shape_space(*real_body(), few(3));
  EXPECT_EQ(one.point_mean, three.point_mean);
  EXPECT_EQ(one.point_basis, three.point_basis);
  EXPECT_EQ(one.bone_mean, three.bone_mean);
  EXPECT_EQ(one.bone_basis, three.bone_basis);
}

// What principal components are: moves of the points at right angles to each other, the largest first. The largest
// is stature.
TEST(ShapeSpaceBuilder, ComponentsAreOrthogonalLargestFirst) {
  IM2FIT_NEEDS_BODY();
  const ShapeSpace space = lab::build_shape_space(*real_body(), few(2));
  ASSERT_EQ(space.shape_count, 6U);
  ASSERT_GE(space.point_count, 250U);
  const auto product = [&](std::size_t a, std::size_t b) {
    double sum = 0;
    for (std::size_t i = 0; i < space.point_count * kPointValues; ++i)
      if (i % kPointValues < 3)
        sum += static_cast<double>(space.point_basis[i * space.shape_count + a]) *
               static_cast<double>(space.point_basis[i * space.shape_count + b]);
    return sum;
  };
  for (std::size_t a = 0; a < space.shape_count; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_LE(product(a, a), product(b, b));
      EXPECT_LT(std::fabs(product(a, b)), 1e-4 * std::sqrt(product(a, a) * product(b, b))) << a << " " << b;
    }
  }
  std::size_t highest = 0;
  for (std::size_t i = 0; i < space.point_count; ++i)
    if (space.point_mean[i * kPointValues + 1] > space.point_mean[highest * kPointValues + 1]) highest = i;
  EXPECT_GT(std::fabs(space.point_basis[(highest * kPointValues + 1) * space.shape_count]), 20);
}

}  // namespace
}  // namespace im2fit::body
