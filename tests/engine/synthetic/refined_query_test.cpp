// SPDX-License-Identifier: Apache-2.0
// Which index may be queried with a fit.
#include "estimate/refined_query.h"

#include <gtest/gtest.h>

#include "body/shape_space.h"
#include "tests/index/refined_people.h"
#include "train/index/builder.h"

namespace im2fit {
namespace {

constexpr std::uint32_t kKey = 4711;

const index::Index& refined_index() {
  static const index::Index index = [] {
    const index::testing::World world;
    std::vector<index::Sample> samples;
    for (std::uint64_t i = 0; i < 600; ++i)
      samples.push_back(index::testing::turned_with_views(world, i, body::kShapePointMin, body::kLimbValues, 0));
    index::BuildOptions options = index::testing::options_for(world);
    options.shape_key = kKey;
    return std::move(*index::Index::parse(*build_index(options, index::source_of(samples)), "refined"));
  }();
  return index;
}

body::ShapeSpace space_of(std::size_t shapes, std::uint32_t key = kKey, std::size_t points = body::kShapePointMin) {
  body::ShapeSpace space;
  space.shape_count = shapes;
  space.point_count = points;
  space.key = key;
  return space;
}

// Whoever says yes to another size has a query read or write past the values.
TEST(RefinedQuery, FitsQueryAnIndexOfTheirSpaceAndSizeAlone) {
  const std::size_t size = refined_index().fit_layout().shapes;
  ASSERT_GT(size, 1U);
  ASSERT_EQ(refined_index().fit_layout().patches, body::kShapePointMin);
  ASSERT_EQ(refined_index().fit_layout().limbs, body::kLimbValues);
  const auto fits = [](const body::ShapeSpace& space) { return RefinedQuery::fits(refined_index(), &space); };
  EXPECT_TRUE(fits(space_of(size)));
  EXPECT_FALSE(fits(space_of(size - 1)));
  EXPECT_FALSE(fits(space_of(size + 1)));
  EXPECT_FALSE(fits(space_of(size, kKey + 1)));
  EXPECT_FALSE(fits(space_of(size, kKey, 0)));
  EXPECT_FALSE(fits(space_of(size, kKey, body::kShapePointMin + 1)));  // one patch more a view
  EXPECT_FALSE(RefinedQuery::fits(refined_index(), nullptr));
}

}  // namespace
}  // namespace im2fit
