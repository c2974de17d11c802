// SPDX-License-Identifier: Apache-2.0
// The same mask, floor and guidance on every machine and in every tier: checksums of whole sequences. A change here
// changes the pixels the features are made of: the index must be built anew.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "core/crc32c.h"
#include "perception/segment/segment.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

using room_test::add;
using room_test::person_at;
using room_test::Picture;
using room_test::render;
using room_test::Scene;

// room_test's own noise uses log and cos, which differ between C libraries; this one only + - * / and rounding.
Picture sensed(Picture p, std::uint64_t seed) {
  constexpr double kStep = 2.85e-6;  // 1/mm: one disparity step
  Rng rng(seed);
  for (std::uint16_t& z : p.depth) {
    const double noise = 0.5 * static_cast<double>(rng.fast_normal());
    if (z != 0) z = static_cast<std::uint16_t>(std::lround(1.0 / (kStep * std::round(1.0 / z / kStep + noise))));
    if (rng.index(50) == 0) z = 0;
    if (rng.index(5000) == 0) z = 65535;
  }
  return p;
}

std::uint32_t checksum(const Person& person, std::span<const std::uint8_t> mask, std::uint32_t previous) {
  const std::vector<std::int32_t> whole = {person.found,
                                           person.people_count,
                                           person.u_min,
                                           person.v_min,
                                           person.u_max,
                                           person.v_max,
                                           person.cut_top,
                                           person.cut_bottom,
                                           person.cut_left,
                                           person.cut_right,
                                           person.floor.known,
                                           person.pixel_count,
                                           static_cast<std::int32_t>(person.guidance)};
  const Vec3f up =
      person.floor.known ? person.floor.up : Vec3f{};  // an unknown floor's is the picture's or gravity's
  const std::vector<float> real = {
      person.centroid_mm.x,         person.centroid_mm.y, person.centroid_mm.z, up.x, up.y, up.z,
      person.floor.camera_height_mm};
  previous = crc32c(std::as_bytes(std::span(whole)), previous);
  previous = crc32c(std::as_bytes(std::span(real)), previous);
  return crc32c(std::as_bytes(mask), previous);
}

struct Sequence {
  const char* name;
  Scene scene;
  std::uint32_t expected;
};

std::vector<Sequence> sequences() {
  const auto standing = [](float z, float wall) {
    Scene s;
    s.wall_z = wall;
    add(s, person_at(0, z));
    return s;
  };
  std::vector<Sequence> out;
  out.push_back({"portrait", standing(2600, 3500), 0});
  Scene s = standing(3000, 4200);
  s.width = 640;
  s.height = 480;
  s.boxes = {{{450, 0, 2500}, {900, 760, 3000}}, {{-800, 700, 2300}, {-440, 740, 2900}}};
  out.push_back({"furnished landscape", s, 0});
  s.capsules.clear();
  s.boxes.clear();
  add(s, person_at(-100, 3000, 1));
  add(s, person_at(640, 3000, 2));
  out.push_back({"two whose hands touch", s, 0});
  s = standing(2900, 3800);
  s.width = 320;
  s.height = 240;
  s.focal = 287.9F;
  out.push_back({"small", s, 0});
  s = standing(2400, 2815);
  s.width = 483;  // cells do not divide it
  s.height = 637;
  out.push_back({"wall close behind", s, 0});
  s = standing(1250, 0);
  s.floor = false;
  s.camera_height = 1350;
  out.push_back({"no floor", s, 0});
  s = standing(2600, 3500);  // a hand held towards the camera
  s.capsules.push_back({{330, 1350, 2250}, {340, 1360, 2150}, 45, 1});
  out.push_back({"pointing", s, 0});
  s = standing(2600, 3500);
  s.capsules.clear();
  out.push_back({"no person", s, 0});
  s = standing(2600, 3500);
  s.width = 160;
  s.height = 120;
  s.focal = 143.9F;
  out.push_back({"a cell a pixel", s, 0});
  const std::uint32_t expected[] = {0x94B75F2C, 0xBC51D0C1, 0x29B941EB, 0xA21B02E0, 0x9D50B88E,
                                    0x7D57D656, 0x6C3620EA, 0x8A60E79A, 0x16772E43};
  for (std::size_t i = 0; i < out.size(); ++i) out[i].expected = expected[i];
  return out;
}

TEST(Golden, SegmentedSequences) {
  for (const Sequence& q : sequences()) {
    Segmenter segmenter(q.scene.width, q.scene.height);
    PersonTracker people;
    const Picture exact = render(q.scene, 0);
    std::uint32_t sum = 0, input = 0;
    for (std::uint64_t frame = 0; frame < 3; ++frame) {
      const Picture p = sensed(exact, 11 + frame);
      std::vector<std::uint8_t> mask(p.depth.size(), 7);
      const Person person =
          segmenter.run(p.view(), q.scene.intrinsics(), people, MaskImage(mask.data(), p.width, p.height));
      input = crc32c(std::as_bytes(std::span(p.depth)), input);
      sum = checksum(person, mask, sum);
    }
    EXPECT_EQ(sum, q.expected) << q.name << ", input " << std::hex << input << ", got 0x" << sum;
  }
}

}  // namespace
}  // namespace im2fit
