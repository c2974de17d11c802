// SPDX-License-Identifier: Apache-2.0
#include "estimate/site_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/crc32c.h"
#include "pipeline_rig.h"

namespace im2fit {
namespace {

using test::Rig;

constexpr auto kWaist = measurement_index(Measurement::waist_girth);
constexpr auto kWeight = measurement_index(Measurement::weight);

SiteCalibration shop() {
  SiteCalibration site;
  site.name = "Shop 3";
  site.people = 21;
  site.index_crc32c = 0x1234ABCD;
  site.rows[kWaist] = {1.01, -4, 6, 1.25};
  site.row_people[kWaist] = 20;
  site.rows[kWeight] = {0.99, 0.5, 0.25, 1};
  site.row_people[kWeight] = 21;
  site.cameras = {{"Kinect 1", 1.02}, {"Kinect 2", 0.99}};
  return site;
}

index::Answer answer() {
  index::Answer a;
  a.measurements.fill({1000, 980, 1030});
  a.measurements[kWeight] = {70, 60, 80};
  a.female = 0.25F;
  return a;
}

TEST(SiteCalibration, AFileGivesBackWhatWasWritten) {
  const auto bytes = shop().file();
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_LT(bytes->size(), 2000U);
  const auto read = SiteCalibration::parse(*bytes, "shop.i2c");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->name, "Shop 3");
  EXPECT_EQ(read->people, 21U);
  EXPECT_EQ(read->index_crc32c, 0x1234ABCDU);
  EXPECT_EQ(read->crc32c, crc32c(*bytes));
  ASSERT_EQ(read->cameras.size(), 2U);
  EXPECT_EQ(read->cameras[1].name, "Kinect 2");
  EXPECT_EQ(read->cameras[1].scale, 0.99);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    EXPECT_EQ(read->rows[m].scale, shop().rows[m].scale);
    EXPECT_EQ(read->rows[m].offset_men, shop().rows[m].offset_men);
    EXPECT_EQ(read->rows[m].offset_women, shop().rows[m].offset_women);
    EXPECT_EQ(read->rows[m].width, shop().rows[m].width);
    EXPECT_EQ(read->row_people[m], shop().row_people[m]);
  }
}

TEST(SiteCalibration, CorrectsValueAndIntervalAndNothingElse) {
  index::Answer a = answer();
  a.nearest = 77;
  shop().for_camera("").apply(a);
  // 1000 * 1.01 - 4 + 0.25 * 10; arms of 20 and 30, each times 1.25 * 1.01.
  EXPECT_FLOAT_EQ(a.measurements[kWaist].value, 1008.5F);
  EXPECT_FLOAT_EQ(a.measurements[kWaist].low, 1008.5F - 25.25F);
  EXPECT_FLOAT_EQ(a.measurements[kWaist].high, 1008.5F + 37.875F);
  // Without a tape value behind it: the same bits.
  EXPECT_EQ(a.measurements[0].value, 1000.0F);
  EXPECT_EQ(a.measurements[0].low, 980.0F);
  EXPECT_EQ(a.measurements[0].high, 1030.0F);
  EXPECT_EQ(a.female, 0.25F);
  EXPECT_EQ(a.nearest, 77U);
}

TEST(SiteCalibration, AKnownCameraScalesLengthsAndTheWeightByItsCube) {
  const SiteCorrection known = shop().for_camera("Kinect 1"), unknown = shop().for_camera("Kinect 9");
  EXPECT_DOUBLE_EQ(known.rows[kWaist].scale, 1.01 * 1.02);
  EXPECT_DOUBLE_EQ(known.rows[kWeight].scale, 0.99 * 1.02 * 1.02 * 1.02);
  EXPECT_EQ(known.rows[0].scale, 1);
  EXPECT_EQ(unknown.rows[kWaist].scale, 1.01);
  EXPECT_TRUE(shop().knows_camera("Kinect 2"));
  EXPECT_FALSE(shop().knows_camera("Kinect 9"));
}

TEST(SiteCalibration, WhatIsOutOfRangeIsNeitherWrittenNorRead) {
  const struct {
    std::function<void(SiteCalibration&)> spoil;
    const char* message;
  } cases[] = {
      {[](auto& s) { s.name = ""; }, "name"},
      {[](auto& s) { s.name = "a\nb"; }, "name"},
      {[](auto& s) { s.name = std::string(64, 'a'); }, "name"},
      {[](auto& s) { s.people = 0; }, "0 people"},
      {[](auto& s) { s.rows[kWaist].scale = 1.3; }, "waist_girth.scale is 1.3"},
      {[](auto& s) { s.rows[kWaist].scale = std::numeric_limits<double>::quiet_NaN(); }, "waist_girth.scale"},
      {[](auto& s) { s.rows[kWaist].offset_men = 201; }, "waist_girth.offset_men"},
      {[](auto& s) { s.rows[kWeight].offset_women = -31; }, "weight.offset_women"},
      {[](auto& s) { s.rows[kWaist].width = 0; }, "waist_girth.width"},
      {[](auto& s) { s.rows[0].width = 2; }, "stature is corrected"},
      {[](auto& s) { s.cameras[0].scale = 2; }, "Kinect 1"},
      {[](auto& s) { s.cameras[1].name = "Kinect 1"; }, "twice"},
      {[](auto& s) {
         s.cameras.resize(17, {"x", 1});
       },
       "17 cameras"},
  };
  for (const auto& c : cases) {
    SiteCalibration site = shop();
    c.spoil(site);
    const auto written = site.file();
    ASSERT_FALSE(written) << c.message;
    EXPECT_THAT(written.error().message, testing::HasSubstr(c.message));
  }
}

TEST(SiteCalibration, EveryTruncationAndEveryDamageThatMattersIsRefused) {
  const std::vector<std::byte> good = *shop().file();
  for (std::size_t size = 0; size < good.size(); ++size)
    ASSERT_FALSE(SiteCalibration::parse(std::span(good).first(size), "cut.i2c")) << size;
  std::size_t refused = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::vector<std::byte> bad = good;
    bad[i] ^= std::byte{0x10};
    const auto read = SiteCalibration::parse(bad, "bad.i2c");
    if (!read) {
      ++refused;
      EXPECT_THAT(read.error().message, testing::HasSubstr("bad.i2c"));
    } else {  // a byte between sections
      EXPECT_EQ(read->rows[kWaist].scale, 1.01) << i;
      EXPECT_EQ(read->name, "Shop 3");
    }
  }
  EXPECT_GT(refused, good.size() * 8 / 10);
  EXPECT_FALSE(SiteCalibration::load("/nonexistent/shop.i2c"));
}

// The engine shows corrected answers alone, on one thread and on two, and keeps the uncorrected ones.
TEST(SiteCalibration, TheEngineCorrectsEveryAnswerItShows) {
  const auto measured = [](bool corrected, bool single_thread) {
    EngineSettings settings = test::with(single_thread);
    if (corrected) settings.site = shop().for_camera("");
    Rig rig(settings);
    for (int i = 0; i < 40; ++i) rig.push(test::Shot{});
    rig.engine->finish();
    return rig.engine->result();
  };
  const EngineResult plain = measured(false, true);
  ASSERT_TRUE(plain.measured);
  EXPECT_EQ(plain.uncorrected[kWaist].value, plain.answer.measurements[kWaist].value);
  for (const bool single_thread : {true, false}) {
    const EngineResult r = measured(true, single_thread);
    ASSERT_TRUE(r.measured);
    index::Answer expected = plain.answer;
    shop().for_camera("").apply(expected);
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      EXPECT_EQ(r.answer.measurements[m].value, expected.measurements[m].value) << m;
      EXPECT_EQ(r.answer.measurements[m].high, expected.measurements[m].high) << m;
      EXPECT_EQ(r.uncorrected[m].value, plain.answer.measurements[m].value) << m;
    }
    EXPECT_NE(r.answer.measurements[kWaist].value, plain.answer.measurements[kWaist].value);
  }
}

}  // namespace
}  // namespace im2fit
