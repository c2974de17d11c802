// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/camera_yaml.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string_view>
#include <vector>

#include "core/file.h"
#include "core/text.h"
#include "hal/folder/calibration_text.h"
#include "hal/folder/calibration_words.h"
#include "hal/intrinsics.h"

namespace im2fit::hal {
namespace {

// As ROS, OpenCV, RealSense, Orbbec, Azure Kinect and kalibr name the lens that Distortion describes.
bool is_known_model(const std::string& name) {
  std::string plain = plain_name(name);
  if (plain.rfind("obdistortion", 0) == 0) plain.erase(0, std::string_view("obdistortion").size());
  constexpr const char* kNames[] = {"",       "plumbbob", "rationalpolynomial", "brownconrady", "brownconradyk6",
                                    "radtan", "opencv",   "rational6kt",        "pinhole"};
  return std::find(std::begin(kNames), std::end(kNames), plain) != std::end(kNames);
}

// Without coefficients, too, their pictures are not a pinhole's.
bool is_fisheye(const std::string& name) {
  const std::string plain = plain_name(name);
  for (const char* word : {"equidistant", "fisheye", "kannala", "omni", "theta"})
    if (plain.find(word) != std::string::npos) return true;
  return false;
}

Status take_distortion(const LensWords& words, const std::string& path, CameraFile& file) {
  const std::vector<double>& values = words.distortion;
  const Error model{ErrorCode::unsupported, path + ": distortion_model is " + excerpt(words.model) +
                                                ", expected plumb_bob or rational_polynomial; undistort the pictures "
                                                "and write zeros"};
  if (is_fisheye(words.model)) return model;
  const std::size_t count = values.size();
  constexpr std::size_t kCounts[] = {0, 4, 5, 8, 12, 14};
  if (std::find(std::begin(kCounts), std::end(kCounts), count) == std::end(kCounts))
    return calibration_lacks(path, "distortion_coefficients", "4, 5 or 8 numbers (k1 k2 p1 p2 k3 k4 k5 k6)");
  for (std::size_t i = 0; i < count; ++i) {
    if (i < file.distortion.coefficients.size())
      file.distortion.coefficients[i] = values[i];
    else if (values[i] != 0)
      return Error{ErrorCode::unsupported,
                   path +
                       ": distortion_coefficients has a thin prism or a tilt (its 9th to 14th "
                       "number is not 0); calibrate again without, or undistort the pictures"};
  }
  if (file.distortion.any() && !is_known_model(words.model)) return model;
  return Ok{};
}

Status check_plausible(const Intrinsics& k, const std::string& path) {
  const auto text = [](float value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.1f", static_cast<double>(value));
    return std::string(digits);
  };
  const auto refused = [&](const std::string& why) { return Error{ErrorCode::invalid_argument, path + ": " + why}; };
  const std::string size = std::to_string(k.width) + "x" + std::to_string(k.height);
  const std::string centre = "cx, cy are " + text(k.cx) + ", " + text(k.cy) + " in pictures of " + size;
  switch (lens_fault(k)) {
    case LensFault::none:
      break;
    case LensFault::field_of_view: {
      const FieldOfView field = field_of_view(k);
      const bool wide = field.horizontal_rad > field.vertical_rad;
      return refused(std::string(wide ? "fx" : "fy") + " is " + text(wide ? k.fx : k.fy) + ", a field of view of " +
                     text(widest_field_deg(k)) + " degrees in pictures of " + size +
                     ", expected 25 to 130; the focal length is another camera's or another mode's");
    }
    case LensFault::centre_turned:
      return refused(centre +
                     ", the centre of pictures that are turned by 90 degrees; exchange cx and cy, or give the "
                     "calibration of pictures as they are stored");
    case LensFault::centre_elsewhere:
      return refused(centre +
                     ", expected in the middle half of both sides; the values are for pictures of another "
                     "size, or for a part of them");
  }
  return Ok{};
}

Result<CameraFile> interpret(const YAML::Node& root, const std::string& path, PictureSize pictures) {
  const auto words = lens_words(root, path, pictures);
  if (!words) return words.error();
  CameraFile file;
  const auto at = [&](std::size_t i) { return static_cast<float>(words->lens[i]); };
  file.intrinsics = {words->size.width, words->size.height, at(0), at(1), at(2), at(3)};
  if (auto ok = check_intrinsics(file.intrinsics, path); !ok) return ok.error();
  if (auto ok = check_plausible(file.intrinsics, path); !ok) return ok.error();
  if (auto ok = take_distortion(*words, path, file); !ok) return ok.error();
  if (root["im2fit_rotate_deg"].IsDefined()) {
    file.rotate_deg = root["im2fit_rotate_deg"].as<int>();
    if (!is_rotation(*file.rotate_deg)) return calibration_lacks(path, "im2fit_rotate_deg", "0, 90, 180 or 270");
  }
  if (root["im2fit_intrinsics_origin"].IsDefined()) {
    const auto origin = parse_origin(root["im2fit_intrinsics_origin"].as<std::string>());
    if (!origin)
      return calibration_lacks(path, "im2fit_intrinsics_origin",
                               "device, calibration_file, field_of_view or synthetic");
    file.origin = *origin;
  }
  if (root["im2fit_confidence_min"].IsDefined()) {
    file.confidence_min = root["im2fit_confidence_min"].as<int>();
    if (*file.confidence_min < 0 || *file.confidence_min > 255)
      return calibration_lacks(path, "im2fit_confidence_min", "a whole number from 0 to 255");
  }
  if (root["im2fit_oni_crc32c"].IsDefined()) {
    const std::string text = root["im2fit_oni_crc32c"].as<std::string>();
    std::uint32_t crc = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), crc, 16);
    if (code != std::errc() || end != text.data() + text.size() || text.size() != 8)
      return calibration_lacks(path, "im2fit_oni_crc32c", "8 hexadecimal digits");
    file.oni_crc32c = crc;
  }
  return file;
}

}  // namespace

Result<CameraFile> load_camera_yaml(const std::string& path, PictureSize pictures) {
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes) return bytes.error();
  return parse_camera_yaml(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()), path, pictures);
}

Result<CameraFile> parse_camera_yaml(const std::string& text, const std::string& path, PictureSize pictures) {
  try {
    const auto tree = calibration_tree(text, path);
    auto file = tree ? interpret(*tree, path, pictures) : Result<CameraFile>(tree.error());
    if (!file) return Error{file.error().code, printable(file.error().message)};
    return file;
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::corrupt, path + " line " + std::to_string(e.mark.line + 1) + ": " + printable(e.msg) +
                                         "; expected a camera calibration in YAML (docs/cameras)"};
  }
}

}  // namespace im2fit::hal
