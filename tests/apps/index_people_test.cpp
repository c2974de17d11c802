// SPDX-License-Identifier: Apache-2.0
// The people an index names by number, drawn again and measured on their meshes, are those it was made from.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "body/measure.h"
#include "data_paths.h"
#include "index/index.h"
#include "train/population/drawn_people.h"

namespace im2fit {
namespace {

TEST(IndexPeople, DrawnAgainMeasureAsTheIndexSays) {
  IM2FIT_NEED_DATA();
  const auto model = body::BodyModel::load(test::body_path());
  ASSERT_TRUE(model) << model.error().message;
  const auto index = index::Index::open(test::index_path());
  ASSERT_TRUE(index) << index.error().message;
  constexpr std::uint32_t kPeople = 24;
  std::array<double, kMeasurementCount> off{};
  for (std::uint32_t i = 0; i < kPeople; ++i) {
    const auto entry = static_cast<std::uint32_t>(index->size() * i / kPeople);
    const index::IndexedPerson person = *index->person_of(entry);
    const auto params = body::params_of_person(*model, person.version, person.seed, person.number);
    ASSERT_TRUE(params) << params.error().message;
    const MeasurementValues drawn = body::measure_person(*model, *params), stored = *index->measurements_of(entry);
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      off[m] += std::abs(static_cast<double>(drawn[m] - stored[m])) / kPeople;
  }
  // The codes round, and people had bumps of up to 3 mm; anybody else is more than twice as far off, as the
  // mean person is.
  for (std::size_t m = 0; m < kMeasurementCount; ++m)
    EXPECT_LT(off[m], 0.4 * static_cast<double>(index->info().prior_mae[m])) << kMeasurementTable[m].id;
}

}  // namespace
}  // namespace im2fit
