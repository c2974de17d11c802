// SPDX-License-Identifier: Apache-2.0
#include "hal/depth_diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
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
  return depth_diagnosis(DepthView(picture.data(), 320, 240));
}

TEST(DepthDiagnosis, ARoomInMillimetresIsSoundToIt) {
  EXPECT_EQ(diagnosis_of([](int mm) { return mm; }), "");
  EXPECT_EQ(diagnosis_of([](int mm) { return mm % 7 == 0 ? 0 : mm; }), "") << "holes";
  EXPECT_EQ(depth_diagnosis(DepthView()), "");
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

TEST(DepthDiagnosis, SaysHowThePictureIsTurned) {
  const auto upright = room(320, 240);
  std::vector<std::uint16_t> turned(upright.size());
  // As a camera on its side sees it: what rotate 90 undoes.
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u)
      turned[static_cast<std::size_t>(v) + 240 * static_cast<std::size_t>(319 - u)] =
          upright[static_cast<std::size_t>(v) * 320 + static_cast<std::size_t>(u)];
  EXPECT_THAT(depth_diagnosis(DepthView(turned.data(), 240, 320)), HasSubstr("--rotate 90"));
  std::vector<std::uint16_t> over(upright.rbegin(), upright.rend());
  EXPECT_THAT(depth_diagnosis(DepthView(over.data(), 320, 240)), HasSubstr("--rotate 180"));
}

}  // namespace
}  // namespace im2fit::hal
