// SPDX-License-Identifier: Apache-2.0
#include "train/tracker/tracker_images.h"

#include <gtest/gtest.h>

namespace im2fit::lab {
namespace {

// A box of 5 x 2 px whose left column is nearest, off the picture's middle.
TEST(TrackerImages, AMirrorShowsTheOtherSideAtTheOtherRay) {
  TrackerImage image;
  image.view.u_first = 7;
  image.view.width = 5;
  image.view.height = 2;
  image.view.fx = image.view.fy = 100;
  image.view.cx = 8.0F;
  image.view.cy = 1.0F;
  image.view.centroid_mm = {30, 5, 1000};
  for (int i = 0; i < 10; ++i) image.view.depth.push_back(static_cast<std::uint16_t>(1000 + i));
  image.truth[joint_index(Joint::LA)] = {100, 1, 2};
  image.truth[joint_index(Joint::RA)] = {-40, 3, 4};
  image.truth[joint_index(Joint::HE)] = {7, 8, 9};
  const TrackerImage other = mirrored(image);
  for (int v = 0; v < 2; ++v) {
    for (int u = 6; u < 13; ++u) {  // a column beyond each side
      const float rx = (static_cast<float>(u) - image.view.cx) / image.view.fx;
      const float ry = (static_cast<float>(v) - image.view.cy) / image.view.fy;
      EXPECT_EQ(other.view.at_ray(-rx, ry), image.view.at_ray(rx, ry)) << u << " " << v;
    }
  }
  EXPECT_EQ(other.view.centroid_mm.x, -30);
  EXPECT_EQ(other.truth[joint_index(Joint::RA)].x, -100);
  EXPECT_EQ(other.truth[joint_index(Joint::LA)].x, 40);
  EXPECT_EQ(other.truth[joint_index(Joint::LA)].y, 3);
  EXPECT_EQ(other.truth[joint_index(Joint::HE)].x, -7);
  // Twice is once.
  EXPECT_EQ(mirrored(other).view.depth, image.view.depth);
  EXPECT_EQ(mirrored(other).view.cx, image.view.cx);
}

}  // namespace
}  // namespace im2fit::lab
