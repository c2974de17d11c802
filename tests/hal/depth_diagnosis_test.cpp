// SPDX-License-Identifier: Apache-2.0
#include "hal/depth_diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <vector>

namespace im2fit::hal {
namespace {

using testing::HasSubstr;

// A wall 3 m away, the floor towards the camera below it, a person at 2 m, 3 mm of noise.
std::vector<std::uint16_t> room(int width, int height) {
  std::vector<std::uint16_t> out;
  unsigned noise = 1;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      noise = noise * 1664525U + 1013904223U;
      const int floor = v > height * 2 / 3 ? 3000 - 2000 * (v - height * 2 / 3) / (height / 3) : 3000;
      const bool person = u > width * 2 / 5 && u < width * 3 / 5 && v > height / 8 && v < height * 7 / 8;
      out.push_back(
          static_cast<std::uint16_t>((person ? std::min(2000, floor) : floor) + static_cast<int>(noise >> 30)));
    }
  return out;
}

std::string diagnosis_of(const std::function<int(int)>& written) {
  auto picture = room(320, 240);
  for (auto& value : picture) value = static_cast<std::uint16_t>(written(value));
  return depth_diagnosis(DepthView(picture.data(), 320, 240)).text;
}

TEST(DepthDiagnosis, ARoomInMillimetresIsSoundToIt) {
  EXPECT_EQ(diagnosis_of([](int mm) { return mm; }), "");
  EXPECT_EQ(diagnosis_of([](int mm) { return mm % 7 == 0 ? 0 : mm; }), "") << "holes";
  EXPECT_EQ(depth_diagnosis(DepthView()).code, DiagnosisCode::none);
}

TEST(DepthDiagnosis, SaysWhatOtherValuesLookLike) {
  EXPECT_THAT(diagnosis_of([](int mm) { return 10 * mm; }), HasSubstr("0.1 mm units; try --unit 0.1"));
  EXPECT_THAT(diagnosis_of([](int mm) { return mm / 10; }), HasSubstr("centimetres; try --unit 10"));
  EXPECT_THAT(diagnosis_of([](int mm) { return mm / 1000; }), HasSubstr("metres; try --unit 1000"));
  EXPECT_THAT(diagnosis_of([](int mm) { return ((mm & 255) << 8) | (mm >> 8); }), HasSubstr("bytes look swapped"));
  EXPECT_THAT(diagnosis_of([](int mm) { return mm << 3; }), HasSubstr("--unit 0.125"));
  int n = 0;
  EXPECT_THAT(diagnosis_of([&](int mm) { return mm | (++n % 5) << 13; }), HasSubstr("confidence bits"));
  EXPECT_THAT(diagnosis_of([&](int mm) { return ++n % 40 < 4 ? 2047 : 1091 - 355000 / mm; }),
              HasSubstr("raw disparity"));
  EXPECT_THAT(diagnosis_of([](int) { return 0; }), HasSubstr("nearly without depth"));
  EXPECT_THAT(diagnosis_of([&](int) { return static_cast<int>((static_cast<unsigned>(++n) * 40503U) & 0xFFFFU); }),
              HasSubstr("more than in a depth picture"));
}

TEST(DepthDiagnosis, OfAUnitAlreadyGivenSaysTheOneInItsPlace) {
  auto picture = room(320, 240);
  for (auto& value : picture) value = static_cast<std::uint16_t>(10 * value);
  const DepthDiagnosis plain = depth_diagnosis(DepthView(picture.data(), 320, 240));
  EXPECT_EQ(read_in_unit(plain, 1).text, plain.text);
  const DepthDiagnosis found = read_in_unit(plain, 2.5);
  EXPECT_EQ(found.text, "read in units of 2.5 mm, the values look like 0.1 mm units; try --unit 0.25");
  EXPECT_FLOAT_EQ(found.unit_mm, 0.25F);
  const DepthDiagnosis dark = {DiagnosisCode::little_depth, 0, 0, "the last picture is nearly without depth"};
  EXPECT_EQ(read_in_unit(dark, 2.5).text, dark.text);
}

TEST(DepthDiagnosis, SaysHowThePictureIsTurned) {
  const auto upright = room(320, 240);
  std::vector<std::uint16_t> turned(upright.size());
  // As a camera on its side sees it: what rotate 90 undoes.
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u)
      turned[static_cast<std::size_t>(v) + 240 * static_cast<std::size_t>(319 - u)] =
          upright[static_cast<std::size_t>(v) * 320 + static_cast<std::size_t>(u)];
  EXPECT_THAT(depth_diagnosis(DepthView(turned.data(), 240, 320)).text, HasSubstr("--rotate 90"));
  std::vector<std::uint16_t> over(upright.rbegin(), upright.rend());
  EXPECT_THAT(depth_diagnosis(DepthView(over.data(), 320, 240)).text, HasSubstr("--rotate 180"));
}

// Of several units that make a room, the one in which a person is found.
TEST(DepthDiagnosis, NamesTheUnitThatWorks) {
  auto picture = room(320, 240);
  for (auto& value : picture) value = static_cast<std::uint16_t>(5 * value);  // fifths
  const DepthView fifths(picture.data(), 320, 240);
  for (const float works : {0.2F, 0.25F, 0.5F}) {
    std::vector<float> asked;
    const DepthDiagnosis found = depth_diagnosis(fifths, [&](float unit_mm) {
      asked.push_back(unit_mm);
      return unit_mm == works ? 0.9F : 0.5F;
    });
    EXPECT_EQ(found.code, DiagnosisCode::unit);
    EXPECT_EQ(found.unit_mm, works);
    EXPECT_THAT(asked, testing::ElementsAre(0.1F, 0.2F, 0.25F, 0.5F)) << "those that make a room";
  }
  auto half = room(320, 240);
  for (auto& value : half) value = static_cast<std::uint16_t>(2 * value);
  const DepthView doubled(half.data(), 320, 240);
  const auto found_in = [&](float right_mm, float score) {
    return depth_diagnosis(doubled, [=](float unit_mm) { return unit_mm == right_mm ? score : 0.0F; });
  };
  EXPECT_EQ(found_in(0.5F, 0.9F).unit_mm, 0.5F) << "6 m might be the middle of a room in millimetres";
  EXPECT_EQ(found_in(1, 0.9F).code, DiagnosisCode::none);
  EXPECT_EQ(found_in(0.5F, 0.01F).code, DiagnosisCode::none);
  EXPECT_EQ(depth_diagnosis(doubled).code, DiagnosisCode::none);
  EXPECT_EQ(depth_diagnosis(fifths).unit_mm, 0.2F) << "without a judge the likeliest";
  EXPECT_EQ(name_of(DiagnosisCode::unit), "UNIT");
}

TEST(DepthDiagnosis, KnowsFloatingPointReadAsIntegers) {
  const auto mm = room(320, 240);
  for (const float unit : {1.0F, 0.001F}) {
    std::vector<float> floats;
    for (const auto value : mm) floats.push_back(static_cast<float>(value) * unit);
    std::vector<std::uint16_t> halves(2 * floats.size());
    std::memcpy(halves.data(), floats.data(), 4 * floats.size());
    EXPECT_EQ(depth_diagnosis(DepthView(halves.data(), 640, 240)).code, DiagnosisCode::float_values) << unit;
  }
}

TEST(IntrinsicsDiagnosis, KnowsACentreOfTheOtherOrientationAndAnImpossibleField) {
  const auto code = [](const Intrinsics& k) { return intrinsics_diagnosis(k).code; };
  EXPECT_EQ(code({480, 640, 575.8F, 575.8F, 239.5F, 319.5F}), DiagnosisCode::none);
  EXPECT_EQ(code({480, 640, 575.8F, 575.8F, 319.5F, 239.5F}), DiagnosisCode::centre);
  EXPECT_EQ(code({480, 480, 575.8F, 575.8F, 239.5F, 239.5F}), DiagnosisCode::none);
  EXPECT_EQ(code({480, 640, 575.8F, 575.8F, 200, 340}), DiagnosisCode::none);
  EXPECT_EQ(code({480, 640, 1500, 1500, 239.5F, 319.5F}), DiagnosisCode::field_of_view);
  EXPECT_EQ(code({480, 640, 140, 140, 239.5F, 319.5F}), DiagnosisCode::field_of_view);
  EXPECT_EQ(code({480, 640, 1400, 1400, 239.5F, 319.5F}), DiagnosisCode::none);
  EXPECT_EQ(code({}), DiagnosisCode::none) << "not known";
}

}  // namespace
}  // namespace im2fit::hal
