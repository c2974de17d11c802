// SPDX-License-Identifier: Apache-2.0
#include "body/warp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "body/measure.h"
#include "body/skeleton.h"
#include "body_pack.h"
#include "train/population/drawn_people.h"
#include "train/population/proportions.h"
#include "train/population/solve.h"

namespace im2fit::body {
namespace {

Params adult(float gender) {
  Params p;
  p.gender = gender;
  return p;
}

TEST(Warp, NoneMovesNothing) {
  IM2FIT_NEEDS_BODY();
  const std::vector<Vec3f> before = mesh_of(*real_body(), adult(1));
  std::vector<Vec3f> after = before;
  apply_warp(*real_body(), {}, after);
  for (std::size_t v = 0; v < before.size(); ++v) ASSERT_EQ(norm(after[v] - before[v]), 0) << v;
}

TEST(Warp, KeepsStatureFloorAndTheMirrorImage) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  const std::vector<Vec3f> before = mesh_of(model, adult(0));
  Params p = adult(0);
  for (std::size_t i = 0; i < kWarpCount; ++i) p.warp.values[i] = i < 7 ? 0.01F : i % 2 == 0 ? 0.12F : -0.08F;
  const std::vector<Vec3f> after = mesh_of(model, p);
  EXPECT_NEAR(stature_mm(model, after), stature_mm(model, before), 0.01);
  EXPECT_EQ(warp_landmarks(model, after).floor, warp_landmarks(model, before).floor);
  double sum_x = 0, moved = 0;
  for (std::size_t v = 0; v < static_cast<std::size_t>(model.body_vertex_count()); ++v) {
    sum_x += static_cast<double>(after[v].x - before[v].x);
    moved = std::max(moved, static_cast<double>(norm(after[v] - before[v])));
  }
  EXPECT_NEAR(sum_x / model.body_vertex_count(), 0, 0.05);
  EXPECT_GT(moved, 10);
  EXPECT_LT(moved, 120);
}

TEST(Warp, SlopesAddUpToIt) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  const std::vector<Vec3f> rest = mesh_of(model, adult(1));
  Warp warp;
  for (std::size_t i = 0; i < kWarpCount; ++i)
    warp.values[i] = (i < 7 ? 0.004F : 0.05F) * static_cast<float>(static_cast<int>(i * 7 % 5) - 2);
  std::vector<Vec3f> warped = rest;
  apply_warp(model, warp, warped);
  std::vector<std::int32_t> some;
  for (std::int32_t v = 0; v < model.body_vertex_count(); v += 17) some.push_back(v);
  std::vector<Vec3f> slopes(some.size() * kWarpCount);
  warp_slopes(model, rest, some, slopes);
  for (std::size_t k = 0; k < some.size(); ++k) {
    Vec3f moved = rest[static_cast<std::size_t>(some[k])];
    for (std::size_t i = 0; i < kWarpCount; ++i) moved = moved + slopes[k * kWarpCount + i] * warp.values[i];
    EXPECT_LT(norm(moved - warped[static_cast<std::size_t>(some[k])]), 0.01F) << some[k];
  }
}

// Bones move with the skin: every joint stays inside, between the extents of its neighbourhood.
TEST(Warp, JointsFollowTheSkin) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  const std::vector<Vec3f> before = mesh_of(model, adult(1));
  Params p = adult(1);
  p.warp[WarpValue::shoulder_breadth] = 0.1F;
  p.warp[WarpValue::upper_arm_length] = 0.08F;
  p.warp[WarpValue::knee_rise] = -0.02F;
  const std::vector<Vec3f> after = mesh_of(model, p);
  const Skeleton from = rest_skeleton(model, before), to = rest_skeleton(model, after);
  const auto at = [](Segment s) { return static_cast<std::size_t>(s); };
  const auto length = [&](const Skeleton& s, Segment bone) { return norm(s.head[at(bone)] - s.tail[at(bone)]); };
  // The joints lie a little below the acromia, where the breadth begins to become the chest's.
  const float outwards = to.head[at(Segment::left_upper_arm)].x / from.head[at(Segment::left_upper_arm)].x;
  EXPECT_GT(outwards, 1.06F);
  EXPECT_LT(outwards, 1.101F);
  EXPECT_NEAR(length(to, Segment::left_upper_arm) / length(from, Segment::left_upper_arm), 1.08F, 0.01F);
  EXPECT_NEAR(length(to, Segment::left_lower_arm) / length(from, Segment::left_lower_arm), 1, 0.01F);
  EXPECT_NEAR(to.head[at(Segment::left_lower_leg)].y - from.head[at(Segment::left_lower_leg)].y,
              -0.02 * stature_mm(model, before), 1);
}

TEST(Warp, GivesTheDimensionsWanted) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  int within = 0, count = 0;
  for (const bool woman : {false, true})
    for (const double weight_kg : {60.0, 78.0, 105.0}) {
      Params p = adult(woman ? 0.0F : 1.0F);
      p.muscle = weight_kg > 90 ? 0.2F : 0.45F;
      (void)solve_stature_and_weight(model, p, 1720, weight_kg);
      const Dimensions wanted = likely_dimensions(woman, 1720, weight_kg, 35, {});
      const std::vector<Vec3f> plain = mesh_of(model, p);
      p.warp = warp_to(model, plain, wanted, {});
      const Dimensions got = dimensions_of(model, mesh_of(model, p));
      // Of sections the girth, and breadth to depth: hulls are larger than a calliper's reading of the same girth.
      for (const Dimension d : {Dimension::chest_girth, Dimension::chest_depth, Dimension::waist_girth,
                                Dimension::buttock_girth, Dimension::calf_girth})
        EXPECT_NEAR(got[d], wanted[d], 3.5) << static_cast<int>(d) << " " << woman << " " << weight_kg;
      const auto ratio = [](const Dimensions& of, Dimension breadth, Dimension depth) {
        return of[breadth] / of[depth];
      };
      EXPECT_NEAR(ratio(got, Dimension::waist_breadth, Dimension::waist_depth),
                  ratio(wanted, Dimension::waist_breadth, Dimension::waist_depth), 0.02);
      EXPECT_NEAR(ratio(got, Dimension::hip_breadth, Dimension::buttock_depth),
                  ratio(wanted, Dimension::hip_breadth, Dimension::buttock_depth), 0.03);
      for (const Dimension d : {Dimension::cervicale_height, Dimension::chest_height, Dimension::waist_height,
                                Dimension::crotch_height, Dimension::knee_height, Dimension::thigh_girth,
                                Dimension::neck_girth, Dimension::upper_arm_length, Dimension::forearm_length}) {
        within += std::abs(got[d] - wanted[d]) < 6 ? 1 : 0;
        ++count;
      }
    }
  EXPECT_GE(within, count * 9 / 10);
}

TEST(Warp, WeightIsMetWithOne) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params p = draw_person(model, Family::training, 4, 2).params;
  ASSERT_FALSE(p.warp.is_none());
  ASSERT_TRUE(solve_stature_and_weight(model, p, 1780, 82));
  const MeasurementValues got = measure_person(model, p);
  EXPECT_NEAR(got[measurement_index(Measurement::stature)], 1780, 0.2);
  EXPECT_NEAR(got[measurement_index(Measurement::weight)], 82, 0.03);
}

// ANSUR II's average soldier, from its own means (US Army, 2012).
TEST(Proportions, AverageSoldierHasTheSurveysMeans) {
  const Dimensions man = likely_dimensions(false, 1756, 85.5, 30, {});
  EXPECT_NEAR(man[Dimension::waist_girth], 941, 12);
  EXPECT_NEAR(man[Dimension::chest_girth], 1059, 12);
  EXPECT_NEAR(man[Dimension::crotch_height], 846, 6);
  const Dimensions woman = likely_dimensions(true, 1628, 67.8, 29, {});
  EXPECT_NEAR(woman[Dimension::waist_girth], 861, 12);
  EXPECT_NEAR(woman[Dimension::buttock_girth], 1021, 10);
  EXPECT_NEAR(woman[Dimension::waist_breadth] / woman[Dimension::waist_depth], 1.418, 0.02);
}

}  // namespace
}  // namespace im2fit::body
