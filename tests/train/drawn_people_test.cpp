// SPDX-License-Identifier: Apache-2.0
// People drawn again from their number.
#include "train/population/drawn_people.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "body/measure.h"
#include "body/params_vector.h"
#include "body_fixture.h"

namespace im2fit::lab {
namespace {

using namespace body;
using DrawnPeople = WithBody;

// Stature and weight of the drawn body, measured on its mesh, are those drawn for the person before any body was
// made.
TEST_F(DrawnPeople, BodiesHaveTheBuildThatWasDrawn) {
  int met = 0;
  for (std::uint64_t number = 0; number < 12; ++number) {
    const Drawn drawn = draw_person(model(), Family::training, 5, number);
    const Build build = draw_build(Family::training, drawn.woman, drawn.seed);
    EXPECT_EQ(drawn.woman, number % 2 == 1);
    std::vector<Vec3f> mesh(static_cast<std::size_t>(model().vertex_count()));
    model().morph(drawn.params, mesh);
    const double off_mm = stature_mm(model(), mesh) - build.stature_mm;
    met += std::abs(off_mm) < 0.5 ? 1 : 0;
  }
  EXPECT_GE(met, 11);  // a build may be beyond the sliders
}

TEST_F(DrawnPeople, NumbersAndSeedsAreDifferentPeople) {
  std::set<std::vector<float>> seen;
  for (const std::uint64_t seed : {1, 2})
    for (std::uint64_t number = 0; number < 6; ++number)
      seen.insert(
          pack_params(*params_of_person(model(), kPopulationVersion, seed, number), model().modifier_names().size()));
  EXPECT_EQ(seen.size(), 12U);
}

TEST_F(DrawnPeople, AgeAloneIsThePersons) {
  for (std::uint64_t number = 0; number < 8; ++number)
    EXPECT_EQ(*age_of_person(kPopulationVersion, 3, number),
              params_of_person(model(), kPopulationVersion, 3, number)->age_years);
  EXPECT_FALSE(age_of_person(kPopulationVersion + 1, 3, 0));
}

// Sliders but stature's and weight's stand on a grid of 2^-16, so that a logarithm's last bit cannot show.
TEST_F(DrawnPeople, SlidersStandOnTheirGrid) {
  const auto params = params_of_person(model(), kPopulationVersion, 9, 3);
  ASSERT_TRUE(params);
  for (const float v : {params->gender, params->muscle, params->proportions, params->cup, params->firmness,
                        params->race[0], params->race[1], params->race[2]})
    EXPECT_EQ(v * 65536, std::round(v * 65536));
  EXPECT_EQ(params->race[0] + params->race[1] + params->race[2], 1.0F);
}

TEST_F(DrawnPeople, AnotherVersionIsRefused) {
  const auto params = params_of_person(model(), kPopulationVersion + 1, 1, 1);
  ASSERT_FALSE(params);
  EXPECT_NE(params.error().message.find("build the index again"), std::string::npos);
}

}  // namespace
}  // namespace im2fit::lab
