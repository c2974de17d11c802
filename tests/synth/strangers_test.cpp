// SPDX-License-Identifier: Apache-2.0
#include "synth/strangers.h"

#include <gtest/gtest.h>

#include "body/shape_spread.h"
#include "synth/shape_variation.h"
#include "tests/synth/body_fixture.h"

namespace im2fit::synth {
namespace {

using namespace body;

class Strangers : public WithBody {};

TEST_F(Strangers, RepeatAndDifferFromTrainingAndFromHeldOut) {
  const Subject a = draw_stranger(model(), 1, 4);
  const Subject b = draw_stranger(model(), 1, 4);
  EXPECT_EQ(a.truth, b.truth);
  EXPECT_EQ(a.params.modifiers, b.params.modifiers);
  EXPECT_NE(a.truth, draw_stranger(model(), 1, 6).truth);
  // The evaluation's own shapes must not be used up here.
  for (const ModifierSpread& row : modifier_spreads()) {
    const int index = model().modifier_index(row.name);
    if (row.training_sd > 0 || index < 0) continue;
    if (row.name == "armslegs/lowerleg-fat") continue;  // of the set that carries weight past its slider
    EXPECT_EQ(a.params.modifiers[static_cast<std::size_t>(index)], 0) << row.name;
  }
  int changed = 0;
  for (std::size_t i = 0; i < a.params.modifiers.size(); ++i) {
    bool known = false;
    for (const ModifierSpread& row : modifier_spreads()) known |= row.name == model().modifier_names()[i];
    changed += !known && a.params.modifiers[i] != 0 ? 1 : 0;
  }
  EXPECT_GT(changed, 10);
  EXPECT_EQ(a.rest_offset_mm.size(), static_cast<std::size_t>(model().body_vertex_count()));
}

TEST_F(Strangers, StayPeople) {
  for (std::uint64_t i = 0; i < 6; ++i) {
    const Subject s = draw_stranger(model(), 3, i);
    EXPECT_EQ(s.woman, i % 2 == 1);
    const float stature = s.truth[measurement_index(Measurement::stature)];
    const float chest = s.truth[measurement_index(Measurement::chest_girth)];
    EXPECT_GT(stature, 1300);
    EXPECT_LT(stature, 2200);
    EXPECT_GT(chest, 600);
    EXPECT_LT(chest, 1700);
  }
}

}  // namespace
}  // namespace im2fit::synth
