// SPDX-License-Identifier: Apache-2.0
#include "body/measure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "body/model_data.h"
#include "body/skeleton.h"
#include "body_pack.h"
#include "core/rng.h"
#include "train/population/solve.h"

namespace im2fit::body {
namespace {

float value(const MeasurementValues& v, Measurement m) {
  return v[measurement_index(m)];
}

struct Measured {
  Params params;
  double stature_mm, weight_kg;
};

// Muscle falls with build, as docs/makehuman.md requires for drawn people.
Measured draw(Rng& rng, const BodyModel& model, int i) {
  Measured d{};
  Params& p = d.params;
  p.gender = i % 2 == 0 ? 1.0F : 0.0F;
  p.age_years = static_cast<float>(rng.uniform(18, 80));
  p.race = {static_cast<float>(rng.uniform()), static_cast<float>(rng.uniform()), static_cast<float>(rng.uniform())};
  p.proportions = static_cast<float>(rng.uniform(0.3, 0.8));
  p.cup = static_cast<float>(rng.uniform());
  p.firmness = static_cast<float>(rng.uniform());
  d.stature_mm = p.gender > 0 ? rng.normal(1755, 70) : rng.normal(1625, 65);
  const double index = std::clamp(rng.normal(27, 5), 18.5, 42.0);
  d.weight_kg = index * d.stature_mm * d.stature_mm * 1e-6;
  p.muscle = static_cast<float>(std::clamp(0.6 - (index - 20) * 0.03 + rng.normal(0, 0.08), 0.0, 1.0));
  p.modifiers.assign(model.modifier_names().size(), 0.0F);
  const auto set = [&](const char* name, double v) {
    p.modifiers[static_cast<std::size_t>(model.modifier_index(name))] = static_cast<float>(v);
  };
  set("hip/hip-scale-horiz", rng.uniform(-0.6, 0.2));
  set("measure/measure-waist-circ", rng.uniform(-0.6, 0.6));
  set("armslegs/upperlegs-height", rng.uniform(-0.5, 0.5));
  return d;
}

TEST(Solve, ThirtyPeopleGetTheirStatureAndWeight) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Rng rng(2024);
  for (int i = 0; i < 30; ++i) {
    Measured d = draw(rng, model, i);
    ASSERT_TRUE(solve_stature_and_weight(model, d.params, d.stature_mm, d.weight_kg))
        << i << ": " << d.stature_mm << " mm " << d.weight_kg << " kg, muscle " << d.params.muscle;
    EXPECT_GE(d.params.weight, 0);
    EXPECT_LE(d.params.weight, 1);
    const MeasurementValues got = measure_person(model, d.params);
    EXPECT_NEAR(value(got, Measurement::stature), d.stature_mm, 0.5);
    EXPECT_NEAR(value(got, Measurement::weight), d.weight_kg, 0.05);
  }
}

// Where the weight slider ends a set of modifiers goes on, each with a kink where it changes sign.
TEST(Solve, LightAndHeavyPeopleGetTheirsWhereverTheirModifiersPoint) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  int light = 0, heavy = 0;
  const auto solve = [&](float others, float buttocks, float muscle, double index) {
    Params p;
    p.gender = 1;
    p.muscle = muscle;
    p.modifiers.assign(model.modifier_names().size(), 0.0F);
    const auto set = [&](const char* name, float v) {
      p.modifiers[static_cast<std::size_t>(model.modifier_index(name))] = v;
    };
    for (const char* name :
         {"torso/torso-scale-horiz", "torso/torso-scale-depth", "hip/hip-scale-horiz", "hip/hip-scale-depth",
          "armslegs/upperleg-fat", "armslegs/upperarm-fat", "armslegs/lowerleg-fat", "stomach/stomach-pregnant"})
      set(name, others);
    set("buttocks/buttocks-volume", buttocks);
    const double weight_kg = index * 1.76 * 1.76;
    if (!solve_stature_and_weight(model, p, 1760, weight_kg)) return;
    light += p.weight == 0 ? 1 : 0;
    heavy += p.weight == 1 ? 1 : 0;
    const MeasurementValues got = measure_person(model, p);
    ASSERT_NEAR(value(got, Measurement::stature), 1760, 0.5) << others << " " << buttocks << " " << index;
    ASSERT_NEAR(value(got, Measurement::weight), weight_kg, 0.05) << others << " " << buttocks << " " << index;
  };
  for (const float muscle : {0.2F, 0.5F, 0.8F})
    for (const float buttocks : {-0.3F, 0.3F})
      for (const float others : {-0.4F, 0.0F, 0.4F})
        for (double index = 17; index < 36; index += 0.4) solve(others, buttocks, muscle, index);
  EXPECT_GT(light, 20);
  EXPECT_GT(heavy, 100);
}

TEST(Solve, WhatCannotBeReachedSaysSoAndGivesTheNearest) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params p;
  p.gender = 1;
  EXPECT_FALSE(solve_stature_and_weight(model, p, 1760, 400));
  EXPECT_NEAR(value(measure_person(model, p), Measurement::stature), 1760, 2);
  EXPECT_LE(p.weight, 1);
  Params q;
  EXPECT_FALSE(solve_stature_and_weight(model, q, 1760, 20));
  EXPECT_EQ(q.weight, 0);
  for (const double bad : {0.0, -5.0, std::numeric_limits<double>::quiet_NaN(), 1e9}) {
    Params r;
    EXPECT_FALSE(solve_stature_and_weight(model, r, bad, 70));
    EXPECT_FALSE(solve_stature_and_weight(model, r, 1700, bad));
  }
}

TEST(Density, FallsFromLeanToObese) {
  EXPECT_EQ(density_kg_m3(1800, 50), 1025);
  EXPECT_EQ(density_kg_m3(1600, 150), 1000);
  EXPECT_NEAR(density_kg_m3(1000, 30), 1012.5, 1e-9);  // midway between 18 and 42 l/m^2
}

// The tape's length by Cauchy's formula on every crossing of the level y with triangles that `keep` allows.
template <class Keep>
double girth_by_widths(const BodyModel& model, std::span<const Vec3f> v, double y, Keep keep) {
  std::vector<std::array<double, 2>> points;
  for (const auto& t : model.body_triangles()) {
    if (!keep(t)) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3f a = v[static_cast<std::size_t>(t[i])], b = v[static_cast<std::size_t>(t[(i + 1) % 3])];
      if ((static_cast<double>(a.y) > y) == (static_cast<double>(b.y) > y)) continue;
      const double s = (y - static_cast<double>(a.y)) / (static_cast<double>(b.y) - static_cast<double>(a.y));
      points.push_back({static_cast<double>(a.x) * (1 - s) + static_cast<double>(b.x) * s,
                        static_cast<double>(a.z) * (1 - s) + static_cast<double>(b.z) * s});
    }
  }
  double length = 0;
  constexpr int kSteps = 2000;
  for (int k = 0; k < kSteps; ++k) {
    const double t = std::numbers::pi * (k + 0.5) / kSteps;
    double low = 1e9, high = -1e9;
    for (const auto& p : points) {
      const double s = p[0] * std::cos(t) + p[1] * std::sin(t);
      low = std::min(low, s);
      high = std::max(high, s);
    }
    length += (high - low) * std::numbers::pi / kSteps;
  }
  return length;
}

TEST(Measure, GirthsAreTakenAtTheirLevels) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  for (const float gender : {0.0F, 1.0F}) {
    Params p;
    p.gender = gender;
    p.age_years = 40;
    p.weight = 0.7F;
    const MeasurementValues got = measure_person(model, p);
    std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count())), posed(rest.size());
    model.morph(p, rest);
    const Skeleton bones = rest_skeleton(model, rest);
    skin(model, rest, bones, relaxed_pose(bones, relaxed_spread_deg(model, rest)), posed);
    const auto no_arms = [&](const std::array<std::int32_t, 3>& t) {
      double arm = 0;
      for (const std::int32_t v : t) {
        const SkinRecord& s = model.data().skin[static_cast<std::size_t>(v)];
        for (std::size_t i = 0; i < 4; ++i) {
          const std::string_view name = kSegmentNames[s.segment[i]];
          if (name.ends_with("_arm") || name.ends_with("_hand")) arm += static_cast<double>(s.weight[i]);
        }
      }
      return arm < 1.5;
    };
    const auto y = [&](std::size_t v) { return static_cast<double>(posed[v].y); };
    const double nipples = (y(8451) + y(1779)) / 2;
    const double waist = y(4116) + (gender > 0 ? 0.145 : 0.239) * (nipples - y(4116));
    EXPECT_NEAR(value(got, Measurement::chest_girth), girth_by_widths(model, posed, nipples, no_arms), 0.2);
    EXPECT_NEAR(value(got, Measurement::waist_girth), girth_by_widths(model, posed, waist, no_arms), 0.2);
    EXPECT_GT(value(got, Measurement::shoulder_girth), value(got, Measurement::chest_girth));
  }
}

TEST(Measure, AChestIsMeasuredWithTheArmsAndAtTheHeightAskedFor) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params p;
  p.gender = 1;
  p.age_years = 40;
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count()));
  model.morph(p, rest);
  Measurer measurer(model);
  const double relaxed = value(measurer.measure_rest_mesh(rest, p.gender), Measurement::chest_girth);
  const double slope = measurer.girth_slopes().chest;
  const float relaxed_deg = relaxed_spread_deg(model, rest);
  EXPECT_NEAR(measurer.chest_girth_mm(rest, relaxed_deg, 0), relaxed, 0.01);
  const double above = measurer.chest_girth_mm(rest, relaxed_deg, 20);
  const double below = measurer.chest_girth_mm(rest, relaxed_deg, -20);
  EXPECT_NEAR((above - below) / 40, slope, 0.001);
  // Linear blend skinning draws the flesh of the armpits inwards where arms are lowered.
  EXPECT_GT(measurer.chest_girth_mm(rest, 30, 0), relaxed + 3);
  EXPECT_LT(measurer.chest_girth_mm(rest, 30, 0), relaxed + 40);
}

TEST(Measure, NeckIsTheSmallestSectionAcrossItsAxis) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params p;
  p.gender = 0.5F;
  p.weight = 0.8F;
  std::vector<Vec3f> mesh = mesh_of(model, p);
  const float got = value(measure_rest_mesh(model, mesh, p.gender), Measurement::neck_girth);
  // The whole body turned until the neck is upright; then every level is a section across it.
  const Vec3f root = mean_of_list(model.data(), kHeadLists + static_cast<std::size_t>(Segment::neck), mesh);
  const Vec3f skull = mean_of_list(model.data(), kHeadLists + static_cast<std::size_t>(Segment::head), mesh);
  const Mat3f upright = rotation_between(skull - root, {0, 1, 0});
  for (Vec3f& v : mesh) v = upright * (v - root);
  const auto near_axis = [&](const std::array<std::int32_t, 3>& t) {
    const Vec3f v = mesh[static_cast<std::size_t>(t[0])];
    return v.x * v.x + v.z * v.z < 150 * 150;
  };
  double smallest = 1e9;
  for (int i = 0; i <= 60; ++i)
    smallest =
        std::min(smallest, girth_by_widths(model, mesh, static_cast<double>(norm(skull - root)) * i / 60, near_axis));
  EXPECT_NEAR(got, smallest, 1.0);
  EXPECT_GT(got, 250);
}

TEST(Measure, LengthsAreInTheRangesOfAnsur) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  struct Row {
    Measurement id;
    double woman, man, slack;  // ANSUR II means, mm; slack: the mesh's own bias (docs/makehuman.md)
  };
  const Row rows[] = {{Measurement::inside_leg, 782, 846, 25},
                      {Measurement::shoulder_breadth, 365, 416, 30},
                      {Measurement::sleeve_length, 311 + 241, 335 + 268, 64},
                      {Measurement::chest_girth, 947, 1059, 60},
                      {Measurement::hip_girth, 1021, 1020, 80}};
  for (const bool man : {false, true}) {
    Params p;
    p.gender = man ? 1.0F : 0.0F;
    p.age_years = 30;
    p.muscle = 0.4F;
    ASSERT_TRUE(solve_stature_and_weight(model, p, man ? 1756 : 1628, man ? 85.5 : 67.8));
    const MeasurementValues got = measure_person(model, p);
    for (const Row& r : rows)
      EXPECT_NEAR(value(got, r.id), man ? r.man : r.woman, r.slack)
          << kMeasurementTable[measurement_index(r.id)].id << man;
  }
}

TEST(Measure, LongerUpperLegsMakeLongerLegsAndNothingElseOfTheArm) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params p;
  const MeasurementValues before = measure_person(model, p);
  p.modifiers.assign(model.modifier_names().size(), 0.0F);
  p.modifiers[static_cast<std::size_t>(model.modifier_index("armslegs/upperlegs-height"))] = 1;
  const MeasurementValues after = measure_person(model, p);
  EXPECT_GT(value(after, Measurement::leg_length), value(before, Measurement::leg_length) + 5);
  EXPECT_GT(value(after, Measurement::inside_leg), value(before, Measurement::inside_leg) + 5);
  EXPECT_NEAR(value(after, Measurement::sleeve_length), value(before, Measurement::sleeve_length), 1);
}

TEST(Measure, SectionsForDrawingAreThoseMeasured) {
  IM2FIT_NEEDS_BODY();
  const BodyModel& model = *real_body();
  Params p;
  p.gender = 0;
  std::vector<Vec3f> rest(static_cast<std::size_t>(model.vertex_count())), posed(rest.size());
  model.morph(p, rest);
  const Skeleton bones = rest_skeleton(model, rest);
  skin(model, rest, bones, relaxed_pose(bones, relaxed_spread_deg(model, rest)), posed);
  const MeasurementValues got = measure_rest_mesh(model, rest, 0);
  const auto sections = girth_sections(model, posed, 0);
  ASSERT_EQ(sections.size(), 5U);
  for (const auto& s : sections) {
    double length = 0;
    for (std::size_t i = 0; i < s.hull.size(); ++i)
      length += static_cast<double>(norm(s.hull[(i + 1) % s.hull.size()] - s.hull[i]));
    EXPECT_NEAR(length, value(got, s.id), 0.05);
  }
}

}  // namespace
}  // namespace im2fit::body
