// SPDX-License-Identifier: Apache-2.0
// A body whose mesh has the reported measurements.
#include "body/fit/measurement_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "allocations.h"
#include "body/fit/posed_shape.h"
#include "body/fit/shape_points.h"
#include "body/look.h"
#include "body/measure.h"
#include "body/model_data.h"
#include "body/tape.h"
#include "body_pack.h"
#include "person/builtin_tape.h"
#include "train/population/drawn_people.h"

namespace im2fit::body {
namespace {

constexpr std::size_t kWeight = measurement_index(Measurement::weight);
constexpr bool is_girth(std::size_t i) {
  const auto m = static_cast<Measurement>(i);
  return m >= Measurement::neck_girth && m <= Measurement::hip_girth;
}

// Half the width of a 95 % interval from the front, halved.
constexpr MeasurementValues kSd = {6, 10, 12, 8, 8, 20, 18, 20, 15, 11, 2};
MeasurementGoals goals_of(const MeasurementValues& values) {
  MeasurementGoals goals;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) goals[i] = {values[i], kSd[i]};
  return goals;
}

double difference(const MeasurementValues& a, const MeasurementValues& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const double d = static_cast<double>(a[i] - b[i]) / static_cast<double>(kSd[i]);
    sum += d * d;
  }
  return sum;
}

// People as in an index, to begin from.
class MeasurementFitTest : public testing::Test {
 protected:
  void SetUp() override { IM2FIT_NEEDS_BODY(); }

  static const std::vector<std::pair<Drawn, MeasurementValues>>& entries() {
    static const auto all = [] {
      std::vector<std::pair<Drawn, MeasurementValues>> people;
      for (std::uint64_t number = 0; number < 320; ++number) {
        Drawn d = draw_person(*real_body(), Family::training, 21, number);
        const MeasurementValues values = measure_person(*real_body(), d.params);
        people.emplace_back(std::move(d), values);
      }
      return people;
    }();
    return all;
  }
  static const Params& nearest(bool woman, const MeasurementValues& to) {
    const Params* best = nullptr;
    double least = std::numeric_limits<double>::max();
    for (const auto& [drawn, values] : entries())
      if (const double d = difference(values, to); drawn.woman == woman && d < least) {
        least = d;
        best = &drawn.params;
      }
    return *best;
  }
};

// Held-out people are shaped by modifiers that no entry has. The report is their measurements, with independent
// errors that take it off the measurements of any body.
TEST_F(MeasurementFitTest, MeetsWhatIsReportedOfThirtyPeople) {
  const BodyModel& model = *real_body();
  MeasurementFitter fitter(model);
  double girth_sum = 0;
  int girths = 0;
  bool slim = false, heavy = false;
  for (std::uint64_t number = 0; number < 30; ++number) {
    const Drawn person = draw_person(model, Family::held_out, 22, number);
    MeasurementValues reported = measure_person(model, person.params);
    const float metres = reported[0] / 1000, mass_index = reported[kWeight] / (metres * metres);
    slim = slim || mass_index < 21;
    heavy = heavy || mass_index > 34;
    Rng rng = Rng::for_item(23, 1, number);
    for (std::size_t i = 0; i < kMeasurementCount; ++i)
      reported[i] += static_cast<float>(0.3 * static_cast<double>(kSd[i]) * std::clamp(rng.normal(), -2.0, 2.0));
    Params params = nearest(person.woman, reported);
    const MeasurementFit fit = fitter.run(params, goals_of(reported));
    const MeasurementValues again = measure_person(model, params);
    EXPECT_EQ(again, fit.values);
    for (std::size_t i = 0; i < kMeasurementCount; ++i) {
      const float off = again[i] - reported[i];
      EXPECT_EQ(fit.residual[i],
                static_cast<float>(static_cast<double>(again[i]) - static_cast<double>(reported[i])));
      EXPECT_LE(std::fabs(off), i == kWeight ? 0.3F : 3.0F) << kMeasurementTable[i].id << " of person " << number;
      if (!is_girth(i)) continue;
      girth_sum += std::fabs(static_cast<double>(off));
      ++girths;
    }
    EXPECT_LE(girth_residual_mm(fit.residual), 2) << "person " << number;
  }
  EXPECT_LE(girth_sum / girths, 1);
  EXPECT_TRUE(slim && heavy) << "the thirty must have several builds";
}

TEST_F(MeasurementFitTest, TheSameBitsAgainAndNoAllocation) {
  const BodyModel& model = *real_body();
  MeasurementFitter fitter(model), other(model);
  const MeasurementValues reported = entries()[7].second;
  const Params start = entries()[9].first.params;
  Params a = start, b = start, c = start;
  const MeasurementFit first = fitter.run(a, goals_of(reported));
  EXPECT_GT(first.steps, 1);
  const std::size_t before = allocations_so_far();
  const MeasurementFit second = fitter.run(b, goals_of(reported));
  EXPECT_EQ(allocations_so_far(), before);
  other.run(c, goals_of(entries()[20].second));  // the fit before leaves no trace
  c = start;
  const MeasurementFit third = other.run(c, goals_of(reported));
  for (const auto& [params, fit] : {std::pair{&b, &second}, std::pair{&c, &third}}) {
    EXPECT_EQ(params->warp.values, a.warp.values);
    EXPECT_EQ(params->modifiers, a.modifiers);
    EXPECT_EQ(params->height, a.height);
    EXPECT_EQ(params->weight, a.weight);
    EXPECT_EQ(fit->values, first.values);
  }
}

TEST_F(MeasurementFitTest, NothingToChangeChangesNothing) {
  MeasurementFitter fitter(*real_body());
  const auto& [drawn, values] = entries()[4];
  Params params = drawn.params;
  const MeasurementFit fit = fitter.run(params, goals_of(values));
  EXPECT_EQ(fit.steps, 0);
  EXPECT_EQ(fit.distance, 0);
  EXPECT_EQ(params.warp.values, drawn.params.warp.values);
}

TEST_F(MeasurementFitTest, WhatNoBodyHasIsApproachedAndSaid) {
  const BodyModel& model = *real_body();
  MeasurementFitter fitter(model);
  MeasurementValues odd = entries()[5].second;
  odd[measurement_index(Measurement::waist_girth)] = 2600;
  odd[measurement_index(Measurement::inside_leg)] = 200;
  odd[kWeight] = 20;
  MeasurementValues least, most, none{};
  least.fill(1);
  most.fill(1e6F);
  for (const MeasurementValues& impossible : {odd, least, most, none}) {
    Params params = entries()[5].first.params;
    const MeasurementFit fit = fitter.run(params, goals_of(impossible));
    EXPECT_GT(girth_residual_mm(fit.residual), kResidualToldMm);
    for (const float v : fit.values) EXPECT_TRUE(std::isfinite(v));
    for (const float v : fit.residual) EXPECT_TRUE(std::isfinite(v));
    for (const float v : params.warp.values) EXPECT_LE(std::fabs(v), 0.6F);
    EXPECT_TRUE(params.height >= 0 && params.height <= 1 && params.weight >= 0 && params.weight <= 1);
  }
}

TEST_F(MeasurementFitTest, GoalsThatAreNotFiniteAreFree) {
  MeasurementFitter fitter(*real_body());
  MeasurementGoals goals = goals_of(entries()[8].second);
  const auto waist = measurement_index(Measurement::waist_girth);
  goals[waist].value = std::numeric_limits<float>::quiet_NaN();
  goals[measurement_index(Measurement::hip_girth)].sd = std::numeric_limits<float>::quiet_NaN();
  Params params = entries()[2].first.params;
  const MeasurementFit fit = fitter.run(params, goals);
  EXPECT_EQ(fit.residual[waist], 0);
  for (std::size_t i = 0; i < kMeasurementCount; ++i) EXPECT_LE(std::fabs(fit.residual[i]), 0.5F);
  // A waist without a target follows the rest.
  EXPECT_NEAR(fit.values[waist], entries()[8].second[waist], 90);
}

// Where goals contradict one another, those known well are met and the others give way.
TEST_F(MeasurementFitTest, TheBetterKnownIsMet) {
  MeasurementFitter fitter(*real_body());
  const auto& [drawn, values] = entries()[6];
  MeasurementGoals goals = goals_of(values);
  const auto crotch = measurement_index(Measurement::inside_leg), legs = measurement_index(Measurement::leg_length);
  goals[crotch] = {values[crotch] - 200, 40};
  goals[legs] = {values[legs] + 150, 1};
  Params params = drawn.params;
  const MeasurementFit fit = fitter.run(params, goals);
  EXPECT_GT(std::fabs(fit.residual[crotch]), 10 * std::fabs(fit.residual[legs]));
}

// A person of the shape space: the result of a perfect fit to pictures.
SeenBody seen_perfectly(const BodyModel& model, const Params& params) {
  const ShapeSpace& space = model.shape_space();
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model.vertex_count()));
  model.morph(params, mesh);
  const std::vector<Quad> quads = quads_of_shape_space(model);
  EXPECT_EQ(quads.size(), space.point_count);
  SeenBody seen;
  seen.valid = true;
  for (std::size_t k = 0; k < space.shape_count; ++k) {  // components are orthogonal
    double along = 0, square = 0;
    for (std::size_t p = 0; p < quads.size(); ++p) {
      Vec3f middle{};
      for (const std::int32_t v : quads[p]) middle = middle + mesh[static_cast<std::size_t>(v)] * 0.25F;
      for (const auto& [axis, value] : {std::pair(0U, middle.x), std::pair(1U, middle.y), std::pair(2U, middle.z)}) {
        const std::size_t at = p * kPointValues + axis;
        const double slope = static_cast<double>(space.point_basis[at * space.shape_count + k]);
        along += slope * static_cast<double>(value - space.point_mean[at]);
        square += slope * slope;
      }
    }
    seen.shape[k] = static_cast<float>(along / square);
  }
  return seen;
}

// How far the front of trunk and thighs lies from another's, mm, along the normals, with neither nearer the camera.
double front_apart_mm(const BodyModel& model, const Params& a, const Params& b) {
  std::vector<Vec3f> of_a(static_cast<std::size_t>(model.vertex_count())), of_b(of_a.size());
  model.morph(a, of_a);
  model.morph(b, of_b);
  const auto normals = vertex_normals(of_b, model.body_quads());
  std::vector<double> off;
  double mean = 0;
  for (std::size_t v = 0; v < static_cast<std::size_t>(model.body_vertex_count()); ++v) {
    const auto s = static_cast<Segment>(model.data().skin[v].segment[0]);
    if (s != Segment::pelvis && s != Segment::abdomen && s != Segment::chest && s != Segment::left_upper_leg &&
        s != Segment::right_upper_leg)
      continue;
    if (normals[v].z < 0.7F) continue;
    off.push_back(static_cast<double>(dot(normals[v], of_a[v] - of_b[v])));
    mean += off.back();
  }
  mean /= static_cast<double>(off.size());
  double sum = 0;
  for (const double d : off) sum += std::fabs(d - mean);
  return sum / static_cast<double>(off.size());
}

TEST_F(MeasurementFitTest, FollowsTheBodySeenAndMeetsTheSame) {
  const BodyModel& model = *real_body();
  if (model.shape_space().point_count == 0) GTEST_SKIP() << "the body file has no shape space: run im2fit-lab fetch";
  MeasurementFitter fitter(model);
  double with = 0, without = 0;
  for (std::uint64_t number = 0; number < 16; ++number) {
    const Drawn person = draw_person(model, Family::held_out, 25, number);
    const MeasurementValues reported = measure_person(model, person.params);
    const SeenBody seen = seen_perfectly(model, person.params);
    const Params start = nearest(person.woman, reported);
    Params blind = start, follows = start, again = start;
    fitter.run(blind, goals_of(reported));
    const std::size_t before = allocations_so_far();
    const MeasurementFit fit = fitter.run(follows, goals_of(reported), &seen);
    EXPECT_EQ(allocations_so_far(), before);
    for (std::size_t i = 0; i < kMeasurementCount; ++i)
      EXPECT_LE(std::fabs(fit.residual[i]), 0.5F) << kMeasurementTable[i].id << " of person " << number;
    without += front_apart_mm(model, blind, person.params);
    with += front_apart_mm(model, follows, person.params);
    fitter.run(again, goals_of(reported), &seen);
    EXPECT_EQ(again.warp.values, follows.warp.values);
    SeenBody none = seen;
    none.valid = false;
    again = start;
    fitter.run(again, goals_of(reported), &none);
    EXPECT_EQ(again.warp.values, blind.warp.values) << "what is not valid says nothing";
  }
  EXPECT_LT(with, 0.8 * without);
}

// The same of a person measured all round: the skin's distance from the space is known, too.
SeenBody seen_all_round(const BodyModel& model, const Params& params) {
  SeenBody seen = seen_perfectly(model, params);
  seen.back = seen.around = true;
  const ShapeSpace& space = model.shape_space();
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model.vertex_count()));
  model.morph(params, mesh);
  const std::vector<Quad> quads = quads_of_shape_space(model);
  RestShape shape(space);
  shape.set_points(std::span(seen.shape).first(space.shape_count));
  for (std::size_t p = 0; p < quads.size(); p += kSeenEach) {
    Vec3f middle{};
    for (const std::int32_t v : quads[p]) middle = middle + mesh[static_cast<std::size_t>(v)] * 0.25F;
    seen.beyond_mm[p / kSeenEach] = dot(normalized(shape.normal(p)), middle - shape.middle(p));
  }
  return seen;
}

// How far every fourth point of trunk, thighs and shins lies from another's along the normals of `seen`, mm, root
// mean square, with both in the same place.
double skins_apart_mm(const BodyModel& model, const SeenBody& seen, const Params& a, const Params& b) {
  std::vector<Vec3f> of_a(static_cast<std::size_t>(model.vertex_count())), of_b(of_a.size());
  model.morph(a, of_a);
  model.morph(b, of_b);
  RestShape shape(model.shape_space());
  shape.set_points(std::span(seen.shape).first(model.shape_space().shape_count));
  const std::vector<Quad> quads = quads_of_shape_space(model);
  std::vector<std::pair<Vec3f, Vec3f>> moves;  // and normals
  Vec3f mean{};
  for (std::size_t p = 0; p < quads.size(); p += kSeenEach) {
    const auto s = static_cast<Segment>(model.shape_space().skin[p].segment[0]);
    if (s != Segment::pelvis && s != Segment::abdomen && s != Segment::chest && s != Segment::left_upper_leg &&
        s != Segment::right_upper_leg && s != Segment::left_lower_leg && s != Segment::right_lower_leg)
      continue;
    Vec3f move{};
    for (const std::int32_t v : quads[p])
      move = move + (of_a[static_cast<std::size_t>(v)] - of_b[static_cast<std::size_t>(v)]) * 0.25F;
    moves.emplace_back(move, normalized(shape.normal(p)));
    mean = mean + move;
  }
  mean = mean * (1 / static_cast<float>(moves.size()));
  double sum = 0;
  for (const auto& [move, normal] : moves) {
    const auto off = static_cast<double>(dot(normal, move - mean));
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(moves.size()));
}

TEST_F(MeasurementFitTest, FollowsTheSkinMeasuredAllRound) {
  const BodyModel& model = *real_body();
  if (model.shape_space().point_count == 0) GTEST_SKIP() << "the body file has no shape space: run im2fit-lab fetch";
  const Tape& tape = builtin_tape();
  const auto calf = static_cast<std::size_t>(definition_index(tape, "calf_girth"));
  std::vector<float> truth(tape.definitions.size()), with(truth.size()), without(truth.size());
  TapeMeasurer measurer(model);
  MeasurementFitter fitter(model);
  double apart_with = 0, apart_without = 0, calf_with = 0, calf_without = 0;
  for (std::uint64_t number = 0; number < 16; ++number) {
    const Drawn person = draw_person(model, Family::held_out, 25, number);
    const MeasurementValues reported = measure_person(model, person.params);
    const SeenBody seen = seen_all_round(model, person.params);
    Params blind = nearest(person.woman, reported), follows = blind;
    fitter.run(blind, goals_of(reported));
    const std::size_t before = allocations_so_far();
    const MeasurementFit fit = fitter.run(follows, goals_of(reported), &seen);
    EXPECT_EQ(allocations_so_far(), before);
    EXPECT_LE(girth_residual_mm(fit.residual), 1) << "person " << number;
    const double apart = skins_apart_mm(model, seen, follows, person.params);
    EXPECT_LT(apart, 10) << "person " << number;
    apart_with += apart;
    apart_without += skins_apart_mm(model, seen, blind, person.params);
    measurer.measure(tape, person.params, truth);
    measurer.measure(tape, follows, with);
    measurer.measure(tape, blind, without);
    calf_with += static_cast<double>(std::fabs(with[calf] - truth[calf]));
    calf_without += static_cast<double>(std::fabs(without[calf] - truth[calf]));
  }
  EXPECT_LT(apart_with, 0.65 * apart_without);
  EXPECT_LT(calf_with, 0.65 * calf_without);
}

// Goals of a report contradict one another a little and give way: a search that comes to rest there keeps the body
// seen.
TEST_F(MeasurementFitTest, AReportWithErrorsKeepsTheBodySeen) {
  const BodyModel& model = *real_body();
  if (model.shape_space().point_count == 0) GTEST_SKIP() << "the body file has no shape space: run im2fit-lab fetch";
  MeasurementFitter fitter(model);
  for (std::uint64_t number = 16; number < 24; ++number) {  // 21 comes to rest a little beyond the limit
    const Drawn person = draw_person(model, Family::held_out, 26, number);
    MeasurementValues reported = measure_person(model, person.params);
    SeenBody seen = seen_perfectly(model, person.params);
    for (float& along : seen.shape) along *= 2;  // a fit to pictures errs, too
    Rng rng = Rng::for_item(27, 1, number);
    for (std::size_t i = 0; i < kMeasurementCount; ++i)
      reported[i] += static_cast<float>(0.8 * static_cast<double>(kSd[i]) * std::clamp(rng.normal(), -2.0, 2.0));
    const Params start = nearest(person.woman, reported);
    Params blind = start, follows = start;
    fitter.run(blind, goals_of(reported));
    const MeasurementFit fit = fitter.run(follows, goals_of(reported), &seen);
    EXPECT_NE(follows.warp.values, blind.warp.values) << "person " << number;
    for (std::size_t i = 0; i < kMeasurementCount; ++i)
      EXPECT_LE(std::fabs(fit.residual[i]), i == kWeight ? 0.3F : 3.0F)
          << kMeasurementTable[i].id << " of person " << number;
  }
}

// How much the line down the front and the line down the back of a trunk bend: the largest second difference of
// depth, mm, at levels 15 mm apart between buttocks and nipples.
double bend_of(const BodyModel& model, std::span<const Vec3f> mesh) {
  const WarpLandmarks marks = warp_landmarks(model, mesh);
  constexpr float kStepMm = 15, kMiddleMm = 40;
  std::array<std::array<double, 2>, 3> last{};
  double most = 0;
  int levels = 0;
  for (float y = marks.buttock; y < marks.nipple; y += kStepMm) {
    std::array<double, 2> depth = {-1e9, -1e9};
    for (const auto& t : model.body_triangles())
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3f a = mesh[static_cast<std::size_t>(t[i])], b = mesh[static_cast<std::size_t>(t[(i + 1) % 3])];
        if ((a.y > y) == (b.y > y)) continue;
        const Vec3f p = a + (b - a) * ((y - a.y) / (b.y - a.y));
        if (std::fabs(p.x) > kMiddleMm) continue;
        depth[0] = std::max(depth[0], static_cast<double>(p.z));
        depth[1] = std::max(depth[1], -static_cast<double>(p.z));
      }
    last = {last[1], last[2], depth};
    if (++levels < 3) continue;
    for (const std::size_t side : {0U, 1U})
      most = std::max(most, std::fabs(last[0][side] - 2 * last[1][side] + last[2][side]));
  }
  return most;
}

TEST_F(MeasurementFitTest, TrunksBendNoMoreThanPeoples) {
  const BodyModel& model = *real_body();
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model.vertex_count()));
  std::vector<double> usual, fitted;
  for (const auto& [drawn, values] : entries()) {
    model.morph(drawn.params, mesh);
    usual.push_back(bend_of(model, mesh));
  }
  MeasurementFitter fitter(model);
  for (std::uint64_t number = 0; number < 30; ++number) {
    const Drawn person = draw_person(model, Family::held_out, 24, number);
    const MeasurementValues reported = measure_person(model, person.params);
    Params params = nearest(person.woman, reported);
    fitter.run(params, goals_of(reported));
    model.morph(params, mesh);
    fitted.push_back(bend_of(model, mesh));
  }
  std::sort(usual.begin(), usual.end());
  std::sort(fitted.begin(), fitted.end());
  EXPECT_LE(fitted[fitted.size() / 2], 1.2 * usual[usual.size() / 2]);
  EXPECT_LE(fitted.back(), 1.2 * usual.back());
}

}  // namespace
}  // namespace im2fit::body
