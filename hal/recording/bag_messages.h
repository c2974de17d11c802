// SPDX-License-Identifier: Apache-2.0
// The messages of ROS 1 that a recording of depth has, as their bytes stand in a rosbag.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/status.h"
#include "hal/recording/bag_file.h"

namespace im2fit::hal {

// sensor_msgs/Image, but for its pixels, which come next.
struct BagImage {
  std::int64_t stamp_ns = 0;
  std::uint32_t width = 0, height = 0, step = 0, data_size = 0;
  std::string encoding;
  bool big_endian = false;
};
// Errors of all: corrupt, io; `what` names file and topic.
Result<BagImage> read_bag_image(const BagMessage& message, const std::string& what);
// Into `picture` of the image's size, in millimetres: 16-bit values times `unit_mm`, or metres of 32FC1. `row` is a
// buffer. Errors: unsupported (another encoding), too.
Status read_bag_pixels(const BagMessage& message, const BagImage& image, double unit_mm, DepthImage picture,
                       std::vector<std::byte>& row, const std::string& what);
bool is_depth_encoding(const std::string& encoding);

// sensor_msgs/CameraInfo
struct BagCameraInfo {
  std::uint32_t width = 0, height = 0;
  std::string model;
  std::vector<double> distortion;
  std::array<double, 9> k{};
  std::array<double, 12> p{};
};
Result<BagCameraInfo> read_bag_camera_info(const BagMessage& message, const std::string& what);

// std_msgs/Float32
Result<float> read_bag_float(const BagMessage& message, const std::string& what);

}  // namespace im2fit::hal
