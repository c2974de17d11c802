// SPDX-License-Identifier: Apache-2.0
// Pictures full of holes: filled for finding people, never where no data lie near; and a person in them is
// still found.
#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "perception/observe/hole_filler.h"
#include "perception/observe/observe.h"
#include "tests/perception/joints_model_builder.h"
#include "tests/perception/segment_scene.h"

namespace im2fit {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr int kReach = kWidth / 40;

struct Frame {
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kWidth * kHeight);
  std::uint16_t& at(int u, int v) { return depth[static_cast<std::size_t>(v * kWidth + u)]; }
  DepthView view() const { return {depth.data(), kWidth, kHeight}; }
};

std::uint16_t plane(int u, int v) {
  return static_cast<std::uint16_t>(2000 + u + 2 * v);
}

Frame plane_picture() {
  Frame frame;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) frame.at(u, v) = plane(u, v);
  return frame;
}

// Squares of 1 to 4 pixels go until `share` of the picture is gone.
void riddle(std::vector<std::uint16_t>& depth, int width, double share, std::uint64_t seed) {
  Rng rng(seed);
  const int height = static_cast<int>(depth.size()) / width;
  std::size_t lost = 0;
  while (static_cast<double>(lost) < share * static_cast<double>(depth.size())) {
    const int side = 1 + rng.index(4), u0 = rng.index(width - 4), v0 = rng.index(height - 4);
    for (int v = v0; v < v0 + side; ++v)
      for (int u = u0; u < u0 + side; ++u) {
        std::uint16_t& z = depth[static_cast<std::size_t>(v * width + u)];
        lost += z != 0 ? 1 : 0;
        z = 0;
      }
  }
}

TEST(HoleFiller, LeavesAPictureWithFewHolesAlone) {
  Frame frame = plane_picture();
  riddle(frame.depth, kWidth, 0.08, 1);
  HoleFiller holes(kWidth, kHeight);
  EXPECT_EQ(holes.run(frame.view()).pixels, frame.depth.data());
  EXPECT_FALSE(holes.filled());
  EXPECT_EQ(holes.run(Frame().view()).at(10, 10), 0) << "nothing at all is no hole";
  EXPECT_FALSE(holes.filled());
}

TEST(HoleFiller, FillsAPlaneToWithinItsSlopeTimesTheReach) {
  Frame frame = plane_picture();
  riddle(frame.depth, kWidth, 0.5, 2);
  HoleFiller holes(kWidth, kHeight);
  const DepthView filled = holes.run(frame.view());
  ASSERT_TRUE(holes.filled());
  int left = 0;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      if (frame.at(u, v) != 0) {
        ASSERT_EQ(filled.at(u, v), frame.at(u, v)) << u << ' ' << v;
      } else if (filled.at(u, v) == 0) {
        ++left;
      } else {
        ASSERT_LE(std::abs(filled.at(u, v) - plane(u, v)), 2 * kReach) << u << ' ' << v;
      }
    }
  EXPECT_LT(left, kWidth * kHeight / 25);
}

TEST(HoleFiller, LeavesWhatIsWideOpenEmpty) {
  Frame frame = plane_picture();
  constexpr int kFrom = 100, kTo = 180;
  for (int v = 0; v < kHeight; ++v)
    for (int u = kFrom; u < kTo; ++u) frame.at(u, v) = 0;
  riddle(frame.depth, kWidth, 0.6, 3);
  HoleFiller holes(kWidth, kHeight);
  const DepthView filled = holes.run(frame.view());
  ASSERT_TRUE(holes.filled());
  for (int v = 0; v < kHeight; ++v)
    for (int u = kFrom + 4; u < kTo - 4; ++u) ASSERT_EQ(filled.at(u, v), 0) << u << ' ' << v;
}

// Depth edges stay where they were but for the reach of a hole, and no depth is made up between the two.
TEST(HoleFiller, InventsNoDepthBetweenPersonAndRoom) {
  Frame frame;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) frame.at(u, v) = u < 160 ? 1500 : 3500;
  riddle(frame.depth, kWidth, 0.5, 4);
  HoleFiller holes(kWidth, kHeight);
  const DepthView filled = holes.run(frame.view());
  ASSERT_TRUE(holes.filled());
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const int z = filled.at(u, v);
      ASSERT_TRUE(z == 0 || z == 1500 || z == 3500) << z;
      ASSERT_FALSE(u < 160 - kReach && z == 3500) << u << ' ' << v;
      ASSERT_FALSE(u >= 160 + kReach && z == 1500) << u << ' ' << v;
    }
}

TEST(HoleFiller, PixelsWithoutDataLeaveTheMask) {
  const std::vector<std::uint16_t> depth = {0, 900, 0, 900, 900, 0};
  std::vector<std::uint8_t> mask = {255, 255, 255, 255, 0, 0};
  EXPECT_FLOAT_EQ(drop_lost_pixels({depth.data(), 3, 2}, {mask.data(), 3, 2}), 0.5F);
  EXPECT_EQ(mask, (std::vector<std::uint8_t>{0, 255, 0, 255, 0, 0}));
  mask.assign(6, 0);
  EXPECT_EQ(drop_lost_pixels({depth.data(), 3, 2}, {mask.data(), 3, 2}), 0.0F);
}

// A PersonDetector whose joints mean nothing: its guidance about the mask counts.
class RiddledRoom : public testing::Test {
 protected:
  RiddledRoom() : bytes_(test::constant_model(0, 0, 0, 0).bytes()), model_(JointModel::parse(bytes_, "model")) {
    scene_.width = kWidth;
    scene_.height = kHeight;
    scene_.focal = 287.9F;
    scene_.camera_height = 1000;
    scene_.pitch_deg = 3;
    scene_.wall_z = 4500;
  }
  Detection sense(double share) {
    PersonDetector sensor(kWidth, kHeight, *model_);
    Detection detection;
    mask_.assign(kWidth * kHeight, 0);
    for (std::uint64_t frame = 0; frame < 4; ++frame) {
      room_test::Picture picture = room_test::render(scene_, 0.5, frame + 1);
      if (share > 0) riddle(picture.depth, kWidth, share, frame + 10);
      detection = sensor.sense(picture.view(), scene_.intrinsics(), MaskImage(mask_.data(), kWidth, kHeight));
      picture_ = picture;
    }
    return detection;
  }

  std::vector<std::byte> bytes_;
  Result<JointModel> model_;
  room_test::Scene scene_;
  room_test::Picture picture_;
  std::vector<std::uint8_t> mask_;
};

TEST_F(RiddledRoom, APersonFullOfHolesIsTooNoisyAndStillFound) {
  ASSERT_TRUE(static_cast<bool>(model_));
  room_test::add(scene_, room_test::person_at(0, 2900));
  for (const double share : {0.45, 0.55}) {
    const Detection detection = sense(share);
    EXPECT_TRUE(detection.person.found) << share;
    EXPECT_EQ(detection.guidance, static_cast<GuidanceSet>(Guidance::too_noisy)) << share;
    int off = 0, on = 0;
    for (std::size_t i = 0; i < mask_.size(); ++i) {
      if (mask_[i] == 0) continue;
      ASSERT_NE(picture_.depth[i], 0) << "a pixel without data is not measured";
      (picture_.owner[i] == 1 ? on : off) += 1;
    }
    EXPECT_GT(on, 10 * off) << share;
  }
}

TEST_F(RiddledRoom, ARoomFullOfHolesHasNoPerson) {
  ASSERT_TRUE(static_cast<bool>(model_));
  scene_.boxes.push_back({{-300, 0, 2700}, {300, 900, 3100}});
  const Detection detection = sense(0.5);
  EXPECT_FALSE(detection.person.found);
  EXPECT_TRUE(has(detection.guidance, Guidance::no_person));
  EXPECT_FALSE(has(detection.guidance, Guidance::too_noisy));
}

TEST_F(RiddledRoom, AFewHolesAreNotNoise) {
  ASSERT_TRUE(static_cast<bool>(model_));
  room_test::add(scene_, room_test::person_at(0, 2900));
  for (const double share : {0.0, 0.05}) {
    const Detection detection = sense(share);
    EXPECT_TRUE(detection.person.found) << share;
    EXPECT_FALSE(has(detection.guidance, Guidance::too_noisy)) << share;
  }
}

}  // namespace
}  // namespace im2fit
