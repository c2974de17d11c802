// SPDX-License-Identifier: Apache-2.0
// Reads the intrinsics and the distortion of a depth camera. Each program names them in its own way: ROS, OpenCV,
// Open3D, RealSense, Orbbec, Azure Kinect, kalibr, and the recorders of phones.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "hal/folder/calibration_text.h"
#include "hal/intrinsics.h"

namespace im2fit::hal {

struct LensWords {
  PictureSize size;
  PinholeLens lens{};
  std::vector<double> distortion;  // OpenCV's order, of any length; empty: none
  std::string model;               // of the distortion; "": not named
};

// The colour picture that ARKit delivers with depth, in landscape.
inline constexpr int kPhoneColourWidth = 1920, kPhoneColourHeight = 1440;

// Of the smaller picture that the camera makes of the same view. Pixel 0 has its centre at 0, so half a pixel takes
// part in scaling a principal point.
PinholeLens scaled_lens(const PinholeLens& lens, double scale);
// True: the centre is within a tenth of a side of the middle of a picture of this size.
bool is_centred(const PinholeLens& lens, int width, int height);

// Names of makers differ in case and signs: "Image_Width", "imageWidth" and "image-width" are one.
std::string plain_name(std::string_view name);
Error calibration_lacks(const std::string& path, const std::string& key, const std::string& expected);

// What the file says of the depth camera. `pictures` chooses among several modes and gives the size where a file has
// none. Numbers are as they stand: nothing is judged but that they are numbers. A key that looks like a part of a
// lens and is not understood is an error, unless it belongs to another camera or is zero. Errors name file and key:
// invalid_argument, unsupported. Throws YAML::Exception for a word where a number is expected.
Result<LensWords> lens_words(const YAML::Node& root, const std::string& path, PictureSize pictures);

}  // namespace im2fit::hal
