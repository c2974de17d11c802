// SPDX-License-Identifier: Apache-2.0
#include "train/population/ood_subjects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "body/measure.h"
#include "body/model_data.h"
#include "tests/train/body_fixture.h"
#include "train/population/drawn_people.h"
#include "train/population/proportions.h"
#include "train/population/shape_spread.h"
#include "train/population/shape_variation.h"
#include "train/population/surface_smoother.h"

namespace im2fit::lab {
namespace {

using namespace body;

class OodSubjects : public WithBody {};

TEST_F(OodSubjects, RepeatAndDifferFromTrainingAndFromHeldOut) {
  const Subject a = draw_ood_subject(model(), 1, 4);
  const Subject b = draw_ood_subject(model(), 1, 4);
  EXPECT_EQ(a.truth, b.truth);
  EXPECT_EQ(a.params.modifiers, b.params.modifiers);
  EXPECT_NE(a.truth, draw_ood_subject(model(), 1, 6).truth);
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
}

// Half of them are of another make: joints move with their surface, which lacks the small details of the first.
TEST_F(OodSubjects, SmoothedOnesKeepTheirBuildAndLoseDetails) {
  int smoothed = 0;
  for (std::uint64_t i = 0; i < 24; ++i) {
    OodVariation never = kOodTrunk, always = kOodTrunk;
    never.smoothed_share = 0;
    always.smoothed_share = 1;
    always.passes_least = always.passes_most = 100;
    const std::size_t all = static_cast<std::size_t>(model().vertex_count());
    smoothed += draw_ood_subject(model(), 1, i).rest_offset_mm.size() == all ? 1 : 0;
    if (i >= 6) continue;
    const Subject plain = draw_ood_subject(model(), 1, i, never), other = draw_ood_subject(model(), 1, i, always);
    // Crowns are smoothed, too.
    EXPECT_NEAR(other.truth[measurement_index(Measurement::stature)],
                plain.truth[measurement_index(Measurement::stature)], 20);
    if (!plain.woman) continue;
    // Of the ring of neighbours about a nipple, how far it stands out.
    const auto out_mm = [&](const Subject& subject) {
      std::vector<Vec3f> rest(all);
      morph_subject(model(), subject, rest);
      const auto nipple = model().data().landmark(Landmark::left_nipple);
      Vec3f sum;
      int count = 0;
      for (const auto& quad : model().body_quads())
        for (std::size_t c = 0; c < 4; ++c)
          if (quad[c] == nipple) sum = sum + rest[static_cast<std::size_t>(quad[(c + 2) % 4])], ++count;
      return norm(rest[static_cast<std::size_t>(nipple)] - sum * (1.0F / static_cast<float>(count)));
    };
    EXPECT_LT(out_mm(other), 0.7F * out_mm(plain)) << i;
  }
  EXPECT_GT(smoothed, 4);
  EXPECT_LT(smoothed, 20);
}

// As many plain passes leave 43 % of the volume. Girths are fitted to the weight afterwards, and would be too large
// for it.
TEST_F(OodSubjects, SmoothingDoesNotShrink) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model().vertex_count()));
  model().morph({}, rest);
  const double before = volume_litres(model(), rest);
  SurfaceSmoother(model()).run(rest, 100);
  const double kept = volume_litres(model(), rest) / before;
  EXPECT_GT(kept, 0.98);
  EXPECT_LT(kept, 1.06);
}

// Of these neither tape nor calliper is believed outright.
TEST_F(OodSubjects, TheTapesShareOfTrunksVaries) {
  Drawn person = draw_person(model(), Family::training, 1, 3);
  person.params.warp = {};
  std::vector<Vec3f> rest(static_cast<std::size_t>(model().vertex_count()));
  model().morph(person.params, rest);
  const Build build = draw_build(Family::training, person.woman, person.seed);
  const auto waist_mm = [&](double tape_share) {
    Rng rng(1);
    std::vector<Vec3f> warped = rest;
    apply_warp(model(), draw_warp(model(), person.woman, build, rng, rest, tape_share), warped);
    return dimensions_of(model(), warped)[Dimension::waist_girth];
  };
  // In ANSUR II a tape is 1.057 times the calliper's ellipse, a mesh's hull 1.01 times its own.
  EXPECT_NEAR(waist_mm(0) / waist_mm(1), 1.01 / 1.057, 0.005);
}

// What is alike on both sides is so to the vertex, on the mirror symmetric base mesh.
TEST_F(OodSubjects, MirroredChangesAreTheSameOnBothSides) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model().vertex_count()));
  model().morph({}, rest);
  rest.resize(static_cast<std::size_t>(model().body_vertex_count()));
  const auto key = [](Vec3f p, float side) {
    return std::array{std::lround(side * p.x * 50), std::lround(p.y * 50), std::lround(p.z * 50)};
  };
  std::map<std::array<long, 3>, std::size_t> at;
  for (std::size_t v = 0; v < rest.size(); ++v) at[key(rest[v], 1)] = v;
  const auto lopsided_mm = [&](const std::vector<Vec3f>& offset) {
    double most = 0;
    int pairs = 0;
    for (std::size_t v = 0; v < rest.size(); ++v) {
      const auto mirror = at.find(key(rest[v], -1));
      if (mirror == at.end()) continue;
      const Vec3f a = offset[v], b = offset[mirror->second];
      most = std::max(most, static_cast<double>(norm(a - Vec3f{-b.x, b.y, b.z})));
      ++pairs;
    }
    EXPECT_GT(pairs, 10000);
    return most;
  };
  for (const bool neck : {false, true}) {
    Mirrored part = neck ? kOodTrunk.neck : kOodTrunk.trunk;
    std::vector<Vec3f> even(rest.size()), uneven(rest.size());
    Rng rng(3), again(3);
    part.uneven_share = 0;
    add_mirrored(model(), rest, part, rng, even);
    part.uneven_share = 1;
    add_mirrored(model(), rest, part, again, uneven);
    double most = 0;
    for (const Vec3f& o : even) most = std::max(most, static_cast<double>(norm(o)));
    EXPECT_GT(most, neck ? 4 : 10);
    EXPECT_LT(most, 150);
    EXPECT_LT(lopsided_mm(even), 0.2);
    EXPECT_GT(lopsided_mm(uneven), neck ? 1 : 3);
  }
}

// Sections move as a whole: so far forwards at a height, whatever is there.
TEST_F(OodSubjects, ShiftsMoveAllThatIsAsHigh) {
  std::vector<Vec3f> rest(static_cast<std::size_t>(model().vertex_count()));
  model().morph({}, rest);
  rest.resize(static_cast<std::size_t>(model().body_vertex_count()));
  const Mirrored only = {.shifts = 2, .shift_sd_mm = 10};
  std::vector<Vec3f> offset(rest.size());
  Rng rng(5);
  add_mirrored(model(), rest, only, rng, offset);
  std::map<long, std::array<float, 2>> range;  // of a millimetre of height
  double most = 0;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    EXPECT_EQ(offset[v].x, 0);
    EXPECT_EQ(offset[v].y, 0);
    const auto [at_height, fresh] = range.try_emplace(std::lround(rest[v].y), std::array{offset[v].z, offset[v].z});
    auto& [low, high] = at_height->second;
    low = std::min(low, offset[v].z);
    high = std::max(high, offset[v].z);
    most = std::max(most, std::abs(static_cast<double>(offset[v].z)));
  }
  EXPECT_GT(most, 2);
  for (const auto& [height, ends] : range) EXPECT_LT(ends[1] - ends[0], 0.02 * most + 0.01) << height;
}

TEST_F(OodSubjects, StayPeople) {
  for (std::uint64_t i = 0; i < 6; ++i) {
    const Subject s = draw_ood_subject(model(), 3, i);
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
}  // namespace im2fit::lab
