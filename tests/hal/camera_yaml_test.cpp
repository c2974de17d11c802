// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/camera_yaml.h"

#include <gtest/gtest.h>

#include "made_folder.h"

namespace im2fit::hal {
namespace {

std::string opencv_yaml() {
  return "%YAML:1.0\n---\nimage_width: 48\nimage_height: 40\n"
         "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
         "   data: [ 4.32e+01, 0., 2.1e+01, 0., 43., 20.5, 0., 0., 1. ]\n"
         "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ 0., 0., 0., 0., 0. "
         "]\n";
}

TEST(CameraYaml, OpenCvsOwnWordingIsRead) {
  const TestFolder folder;
  put(folder.path("c.yaml"), opencv_yaml());
  const auto file = load_camera_yaml(folder.path("c.yaml"));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->intrinsics.fx, 43.2F);
  EXPECT_EQ(file->intrinsics.cy, 20.5F);
  EXPECT_FALSE(file->rotate_deg);
}

// As they come from ROS 2, Open3D and makers' programs.
TEST(CameraYaml, CalibrationsOfOthersAreRead) {
  const char* const kTexts[] = {
      "header:\n  stamp: {sec: 1, nanosec: 2}\n  frame_id: camera\nheight: 480\nwidth: 640\n"
      "distortion_model: plumb_bob\nd: [0.0, 0.0, 0.0, 0.0, 0.0]\nk: [570.0, 0.0, 320.0, 0.0, 571.0, 240.0, 0.0, "
      "0.0, 1.0]\n"
      "r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\nbinning_x: 0\n---\n",
      R"({"width": 640, "height": 480, "intrinsic_matrix": [570.0, 0, 0, 0, 571.0, 0, 320.0, 240.0, 1]})",
      R"({"width": 640, "height": 480, "fx": 570.0, "fy": 571.0, "ppx": 320.0, "ppy": 240.0, "model": "Brown Conrady", "coeffs": [0,0,0,0,0]})",
      R"({"depth": {"intrinsic": {"width": 640, "height": 480, "fx": 570.0, "fy": 571.0, "cx": 320.0, "cy": 240.0}}})"};
  for (const char* text : kTexts) {
    const auto file = parse_camera_yaml(text, "camera.yaml");
    ASSERT_TRUE(file) << file.error().message << "\n" << text;
    const Intrinsics& k = file->intrinsics;
    EXPECT_EQ(k.width, 640);
    EXPECT_EQ(k.height, 480);
    EXPECT_EQ(k.fx, 570.0F);
    EXPECT_EQ(k.fy, 571.0F);
    EXPECT_EQ(k.cx, 320.0F);
    EXPECT_EQ(k.cy, 240.0F);
  }
  EXPECT_FALSE(parse_camera_yaml(R"({"width": 640, "height": 480, "fx": 570.0})", "camera.yaml"));
  EXPECT_FALSE(parse_camera_yaml(R"({"depth": {"depth": {"depth": 1}}})", "camera.yaml"));
}

TEST(CameraYaml, AnErrorThatQuotesTheFileIsStillOneLine) {
  const auto file = parse_camera_yaml(
      "image_width: 4\nimage_height: 3\ncamera_matrix: {data: [3, 0, 1, 0, 3, 1, 0, 0, 1]}\n"
      "distortion_coefficients: [1, 0, 0, 0]\ndistortion_model: \"fish\\neye\"\n",
      "camera.yaml");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::unsupported);
  EXPECT_FALSE(contains(file.error().message, "\n"));
  EXPECT_TRUE(contains(file.error().message, "fish eye"));
}

}  // namespace
}  // namespace im2fit::hal
