// SPDX-License-Identifier: Apache-2.0
// A person too near to be found is reported; a wall, a box or a corner as near is not a person.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "perception/segment/segment.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::Scene;

constexpr GuidanceSet kNoPerson = static_cast<GuidanceSet>(Guidance::no_person);

Scene near_room(bool portrait) {
  Scene s;
  s.width = portrait ? 240 : 320;
  s.height = portrait ? 320 : 240;
  s.focal = 287.9F;
  s.camera_height = 1450;
  s.wall_z = 3000;
  return s;
}

GuidanceSet guidance_of(const std::vector<std::vector<std::uint16_t>>& frames, const Intrinsics& k) {
  Segmenter segmenter(k.width, k.height);
  PersonTracker people;
  std::vector<std::uint8_t> mask(frames[0].size());
  GuidanceSet last = 0;
  for (const auto& depth : frames)
    last = segmenter.run({depth.data(), k.width, k.height}, k, people, {mask.data(), k.width, k.height}).guidance;
  return last;
}

GuidanceSet guidance_of(const Scene& s) {
  std::vector<std::vector<std::uint16_t>> frames;
  for (std::uint64_t i = 1; i <= 4; ++i) frames.push_back(room_test::render(s, 0.5, i).depth);
  return guidance_of(frames, s.intrinsics());
}

// Two upright planes that meet at the camera's axis `z_mm` away and fall off by `slope_left`, `slope_right` (depth
// per distance sideways): a corner seen from outside; equal and opposite slopes make one wall, turned.
std::vector<std::uint16_t> planes(const Intrinsics& k, float z_mm, float slope_left, float slope_right) {
  std::vector<std::uint16_t> depth;
  for (int v = 0; v < k.height; ++v)
    for (int u = 0; u < k.width; ++u) {
      const float ray = (static_cast<float>(u) - k.cx) / k.fx;  // x / z; z = z_mm + slope |x|
      const float z = z_mm / (1 - (ray < 0 ? slope_left * -ray : slope_right * ray));
      depth.push_back(z > 0 && z < 8000 ? static_cast<std::uint16_t>(std::lround(z)) : std::uint16_t{0});
    }
  return depth;
}

TEST(TooNear, APersonIsReportedAsTooNear) {
  for (const bool portrait : {false, true})
    for (const float z : {700.0F, 800.0F, 900.0F})
      for (const float side : {-60.0F, 0.0F, 60.0F}) {
        Scene s = near_room(portrait);
        room_test::add(s, room_test::person_at(side, z + 130));
        const GuidanceSet guidance = guidance_of(s);
        EXPECT_TRUE(has(guidance, Guidance::too_near)) << portrait << ' ' << z << ' ' << side;
        EXPECT_FALSE(has(guidance, Guidance::no_person)) << portrait << ' ' << z << ' ' << side;
      }
}

TEST(TooNear, AWallIsNoPersonHoweverItIsTurned) {
  for (const bool portrait : {false, true}) {
    const Intrinsics k = near_room(portrait).intrinsics();
    for (const float z : {600.0F, 750.0F, 900.0F})
      for (const float slope : {0.0F, 0.2F, 0.5F, 1.0F, -0.3F, -0.8F})
        EXPECT_EQ(guidance_of({planes(k, z, -slope, slope)}, k), kNoPerson) << z << ' ' << slope;
  }
}

TEST(TooNear, ACornerIsNoPerson) {
  for (const bool portrait : {false, true}) {
    const Intrinsics k = near_room(portrait).intrinsics();
    for (const float z : {600.0F, 750.0F, 900.0F})
      for (const float left : {0.1F, 0.3F, 0.6F, 1.0F})
        for (const float right : {0.1F, 0.3F, 0.6F, 1.0F})
          EXPECT_EQ(guidance_of({planes(k, z, left, right)}, k), kNoPerson) << z << ' ' << left << ' ' << right;
  }
}

TEST(TooNear, ABoxIsNoPerson) {
  for (const bool portrait : {false, true})
    for (const float z : {600.0F, 750.0F, 900.0F})
      for (const float left : {-500.0F, -250.0F, -50.0F, 80.0F}) {
        Scene s = near_room(portrait);
        s.boxes.push_back({{left, 0, z}, {left + 450, 1650, z + 400}});
        EXPECT_EQ(guidance_of(s), kNoPerson) << portrait << ' ' << z << ' ' << left;
      }
}

}  // namespace
}  // namespace im2fit
