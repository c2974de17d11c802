// SPDX-License-Identifier: Apache-2.0
// Where fits to measurements begin.
#include "body/start_bodies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "body/fit/measurement_fit.h"
#include "body/fit/nearest_start.h"
#include "body/measure.h"
#include "body/model_data.h"
#include "body/params_vector.h"
#include "body_pack.h"
#include "core/file.h"
#include "train/population/drawn_people.h"
#include "train/population/start_body_picker.h"

namespace im2fit::body {
namespace {

class StartBodiesTest : public testing::Test {
 protected:
  void SetUp() override {
    IM2FIT_NEEDS_BODY();
    ASSERT_GT(real_body()->start_bodies().size(), 0U);
  }
};

// What the file says a start body measures is what its mesh measures, to the rounding of its parameters.
TEST_F(StartBodiesTest, MeasureWhatTheFileSays) {
  const StartBodies& starts = real_body()->start_bodies();
  EXPECT_EQ(starts.size(), 200U);
  EXPECT_EQ(starts.man_count, 100U);
  for (std::size_t i = 0; i < starts.size(); i += 7) {
    const Params params = starts.params(i);
    EXPECT_EQ(params.gender > 0.5F, i < starts.man_count);
    const MeasurementValues own = measure_person(*real_body(), params);
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      EXPECT_NEAR(own[m], starts.measured[i][m], 0.2) << kMeasurementTable[m].id << " of start body " << i;
  }
}

// Slim and heavy, short and tall, of each sex.
TEST_F(StartBodiesTest, CoverBuilds) {
  const StartBodies& starts = real_body()->start_bodies();
  for (const bool woman : {false, true}) {
    float shortest = 1e9F, tallest = 0, slimmest = 1e9F, heaviest = 0;
    for (std::size_t i = woman ? starts.man_count : 0; i < (woman ? starts.size() : starts.man_count); ++i) {
      const MeasurementValues& m = starts.measured[i];
      const float metres = m[measurement_index(Measurement::stature)] / 1000;
      const float mass_index = m[measurement_index(Measurement::weight)] / (metres * metres);
      shortest = std::min(shortest, metres), tallest = std::max(tallest, metres);
      slimmest = std::min(slimmest, mass_index), heaviest = std::max(heaviest, mass_index);
    }
    EXPECT_GT(tallest - shortest, 0.25F) << woman;  // more than three standard deviations
    EXPECT_LT(slimmest, 19) << woman;
    EXPECT_GT(heaviest, 40) << woman;
  }
}

// By the distance's formula over all of the sex, and a start body is nearest to itself.
TEST_F(StartBodiesTest, TheNearestIsOfTheSexAndNoneIsNearer) {
  const StartBodies& starts = real_body()->start_bodies();
  for (std::size_t i = 0; i < starts.size(); i += 13)
    EXPECT_EQ(nearest_start(starts, i >= starts.man_count, starts.measured[i]), i);
  MeasurementValues someone = starts.measured[3];
  someone[measurement_index(Measurement::waist_girth)] += 60;
  someone[measurement_index(Measurement::weight)] += 5;
  for (const bool woman : {false, true}) {
    const std::size_t found = nearest_start(starts, woman, someone);
    EXPECT_EQ(found >= starts.man_count, woman);
    const MeasurementDistance distance(woman);
    for (std::size_t i = woman ? starts.man_count : 0; i < (woman ? starts.size() : starts.man_count); ++i)
      EXPECT_GE(distance.squared(starts.measured[i], someone), distance.squared(starts.measured[found], someone));
  }
}

// The distance is in standard deviations of people: half of the squares of two people's differences is about the
// number of things that a tape can find out, eleven.
TEST_F(StartBodiesTest, TheDistanceIsInStandardDeviationsOfPeople) {
  for (const bool woman : {false, true}) {
    std::vector<MeasurementValues> people;
    for (std::uint64_t i = 0; i < 24; ++i)
      people.push_back(measure_person(
          *real_body(), draw_person(*real_body(), Family::training, 77, 2 * i + (woman ? 1 : 0)).params));
    const MeasurementDistance distance(woman);
    double sum = 0;
    int pairs = 0;
    for (std::size_t a = 0; a < people.size(); ++a)
      for (std::size_t b = 0; b < a; ++b, ++pairs) sum += distance.squared(people[a], people[b]);
    EXPECT_GT(0.5 * sum / pairs, 4) << woman;
    EXPECT_LT(0.5 * sum / pairs, 25) << woman;
  }
  const MeasurementDistance distance(false);
  MeasurementValues one = real_body()->start_bodies().measured[0], other = one;
  other[measurement_index(Measurement::hip_girth)] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(distance.squared(one, other), 0);
}

// Held-out people, shaped by modifiers that no start body has.
TEST_F(StartBodiesTest, FitsFromTheNearestMeetWhatHundredPeopleMeasure) {
  const BodyModel& model = *real_body();
  MeasurementFitter fitter(model);
  int steps = 0, met = 0;
  constexpr int kPeople = 100;
  for (std::uint64_t number = 0; number < kPeople; ++number) {
    const Drawn person = draw_person(model, Family::held_out, 29, number);
    const MeasurementValues wanted = measure_person(model, person.params);
    MeasurementGoals goals;
    for (std::size_t i = 0; i < kMeasurementCount; ++i) goals[i] = {wanted[i], 0.01F * wanted[i]};
    Params params = model.start_bodies().params(nearest_start(model.start_bodies(), person.woman, wanted));
    const MeasurementFit fit = fitter.run(params, goals);
    EXPECT_LE(girth_residual_mm(fit.residual), 2) << "person " << number;
    met += girth_residual_mm(fit.residual) <= 0.3F ? 1 : 0;
    steps += fit.steps;
  }
  EXPECT_GE(met, 98);
  EXPECT_LE(steps, 7 * kPeople);
  RecordProperty("steps", steps);
}

TEST_F(StartBodiesTest, AreTheSameForAnyNumberOfThreads) {
  lab::StartBodyOptions options;
  options.people = 20;
  options.starts = 6;
  options.threads = 1;
  const auto one = lab::pick_start_bodies(*real_body(), options);
  options.threads = 3;
  const auto three = lab::pick_start_bodies(*real_body(), options);
  ASSERT_EQ(one.men.size(), 3U);
  ASSERT_EQ(one.women.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(one.men[i].measured, three.men[i].measured);
    EXPECT_EQ(one.women[i].measured, three.women[i].measured);
  }
}

TEST_F(StartBodiesTest, AFileWithOthersHasThose) {
  const auto pack = read_file(body_pack_path());
  ASSERT_TRUE(pack);
  StartBody man, woman;
  man.params.gender = 1;
  man.params.age_years = 44;
  man.params.modifiers.assign(real_body()->modifier_names().size(), 0.0F);
  man.params.modifiers[5] = -0.7F;
  man.params.warp.values[2] = 0.03F;
  woman.params.gender = 0.1F;
  man.measured.fill(1000), woman.measured.fill(900);
  auto file = with_start_bodies(*pack, {&man, 1}, {&woman, 1});
  ASSERT_TRUE(file) << file.error().message;
  const auto model = BodyModel::parse(std::move(*file), "other");
  ASSERT_TRUE(model) << model.error().message;
  const StartBodies& starts = model->start_bodies();
  ASSERT_EQ(starts.size(), 2U);
  const std::size_t count = model->modifier_names().size();
  const auto expected = pack_params(man.params, count), found = pack_params(starts.params(0), count);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found[i], expected[i], 0.002) << i;
  EXPECT_EQ(starts.measured[1], woman.measured);
  EXPECT_EQ(model->shape_space().key, real_body()->shape_space().key);

  // What cannot be read is not written.
  EXPECT_FALSE(with_start_bodies(*pack, {}, {&woman, 1}));
  man.measured[4] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(with_start_bodies(*pack, {&man, 1}, {&woman, 1}));
}

// Sections that lie are refused by name.
TEST_F(StartBodiesTest, DamageIsNamed) {
  const auto pack = read_file(body_pack_path());
  ASSERT_TRUE(pack);
  const auto reader = ContainerReader::parse(*pack, kBodyMagic, kBodyVersion, "body");
  ASSERT_TRUE(reader) << reader.error().message;
  const auto with = [&](const std::string& changed, auto change) {
    ContainerWriter writer(kBodyMagic, kBodyVersion);
    for (const auto& [name, entry] : reader->entries()) {
      const auto section = *reader->section(name);
      std::vector<std::byte> bytes(section.begin(), section.end());
      if (name == changed) change(bytes);
      writer.add(name, std::move(bytes));
    }
    const auto model = BodyModel::parse(writer.finish(), "body");
    return model ? std::string("read") : model.error().message;
  };
  const auto put = [](std::size_t at, auto value) {
    return [at, value](std::vector<std::byte>& bytes) { std::memcpy(bytes.data() + at, &value, sizeof value); };
  };
  using testing::HasSubstr;
  EXPECT_EQ(with("start_about", [](auto&) {}), "read");
  EXPECT_THAT(with("start_about", put(0, std::uint32_t{0})), HasSubstr("start_about"));
  EXPECT_THAT(with("start_about", put(0, std::uint32_t{101})), HasSubstr("start_steps"));
  EXPECT_THAT(with("start_columns", put(0, std::uint32_t{60000})), HasSubstr("start_columns"));
  EXPECT_THAT(with("start_columns", put(8, std::uint32_t{0})), HasSubstr("start_columns"));
  EXPECT_THAT(with("start_columns", put(4, 1.0F)), HasSubstr("start_columns"));
  EXPECT_THAT(with("start_columns", put(4, std::numeric_limits<float>::quiet_NaN())), HasSubstr("start_columns"));
  EXPECT_THAT(with("start_measured", put(0, -5.0F)), HasSubstr("start_measured"));
  EXPECT_THAT(with("start_steps", [](auto& bytes) { bytes.pop_back(); }), HasSubstr("start_steps"));
}

}  // namespace
}  // namespace im2fit::body
