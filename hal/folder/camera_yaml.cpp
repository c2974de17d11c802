// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/camera_yaml.h"

#include <yaml-cpp/yaml.h>

#include <charconv>
#include <cstddef>
#include <vector>

#include "core/file.h"
#include "hal/intrinsics.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kFileBytesMax = 1U << 20;  // a calibration is a page of text

Error lacks(const std::string& path, const std::string& key, const std::string& expected) {
  return {ErrorCode::invalid_argument, path + ": " + key + " is missing or not " + expected +
                                           "; write it as ROS or OpenCV calibration does (docs/cameras)"};
}

// Errors may quote the file, which may hold anything.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return text;
}

// OpenCV begins with "%YAML:1.0", which is not the directive YAML knows, and tags matrices with its own type.
std::string without_directive(std::string text) {
  if (text.rfind("%YAML", 0) == 0) text.erase(0, text.find('\n'));
  return text;
}

Result<std::vector<double>> matrix(const YAML::Node& root, const std::string& path, const std::string& key) {
  const YAML::Node node = root[key];
  const YAML::Node data = node.IsDefined() && node.IsMap() ? node["data"] : node;
  if (!data.IsDefined() || !data.IsSequence()) return lacks(path, key, "a matrix with data: [...]");
  std::vector<double> values;
  for (const auto& item : data) values.push_back(item.as<double>());
  return values;
}

Status read_distortion(const YAML::Node& root, const std::string& path, CameraFile& file) {
  if (!root["distortion_coefficients"].IsDefined()) return Ok{};
  const auto values = matrix(root, path, "distortion_coefficients");
  if (!values) return values.error();
  const std::size_t count = values->size();
  if (count != 0 && count != 4 && count != 5 && count != 8)
    return lacks(path, "distortion_coefficients", "4, 5 or 8 numbers (k1 k2 p1 p2 k3 k4 k5 k6)");
  for (std::size_t i = 0; i < count; ++i) file.distortion.coefficients[i] = (*values)[i];
  if (!file.distortion.any()) return Ok{};
  const YAML::Node model = root["distortion_model"];
  const std::string name = model.IsDefined() ? model.as<std::string>() : "plumb_bob";
  if (name != "plumb_bob" && name != "rational_polynomial")
    return Error{ErrorCode::unsupported, path + ": distortion_model is " + name + ", expected plumb_bob or " +
                                             "rational_polynomial; undistort the pictures and write zeros"};
  return Ok{};
}

Result<CameraFile> interpret(const YAML::Node& root, const std::string& path) {
  if (!root.IsMap()) return lacks(path, "image_width", "a whole number");
  CameraFile file;
  Intrinsics& k = file.intrinsics;
  for (const auto& [key, value] : {std::pair{"image_width", &k.width}, std::pair{"image_height", &k.height}}) {
    if (!root[key].IsDefined() || !root[key].IsScalar()) return lacks(path, key, "a whole number of pixels");
    *value = root[key].as<int>();
  }
  const auto camera = matrix(root, path, "camera_matrix");
  if (!camera) return camera.error();
  if (camera->size() != 9) return lacks(path, "camera_matrix", "9 numbers (3 x 3, row by row)");
  const auto at = [&](std::size_t i) { return static_cast<float>((*camera)[i]); };
  k.fx = at(0);
  k.cx = at(2);
  k.fy = at(4);
  k.cy = at(5);
  if (auto ok = check_intrinsics(k, path); !ok) return ok.error();
  if ((*camera)[1] != 0 || (*camera)[3] != 0 || (*camera)[6] != 0 || (*camera)[7] != 0 || (*camera)[8] != 1)
    return Error{ErrorCode::unsupported,
                 path + ": camera_matrix has skew or is no pinhole matrix; expected [fx,0,cx, 0,fy,cy, 0,0,1]"};
  if (auto ok = read_distortion(root, path, file); !ok) return ok.error();
  if (root["im2fit_rotate_deg"].IsDefined()) {
    file.rotate_deg = root["im2fit_rotate_deg"].as<int>();
    if (!is_rotation(*file.rotate_deg)) return lacks(path, "im2fit_rotate_deg", "0, 90, 180 or 270");
  }
  if (root["im2fit_intrinsics_origin"].IsDefined()) {
    const auto origin = parse_origin(root["im2fit_intrinsics_origin"].as<std::string>());
    if (!origin)
      return lacks(path, "im2fit_intrinsics_origin", "device, calibration_file, field_of_view or synthetic");
    file.origin = *origin;
  }
  if (root["im2fit_oni_crc32c"].IsDefined()) {
    const std::string text = root["im2fit_oni_crc32c"].as<std::string>();
    std::uint32_t crc = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), crc, 16);
    if (code != std::errc() || end != text.data() + text.size() || text.size() != 8)
      return lacks(path, "im2fit_oni_crc32c", "8 hexadecimal digits");
    file.oni_crc32c = crc;
  }
  return file;
}

}  // namespace

Result<CameraFile> load_camera_yaml(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  if (bytes->size() > kFileBytesMax)
    return Error{ErrorCode::corrupt, path + " is larger than 1 MiB; expected a camera calibration in YAML"};
  return parse_camera_yaml(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()), path);
}

Result<CameraFile> parse_camera_yaml(const std::string& text, const std::string& path) {
  try {
    auto file = interpret(YAML::Load(without_directive(text)), path);
    if (!file) return Error{file.error().code, one_line(file.error().message)};
    return file;
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::corrupt, path + " line " + std::to_string(e.mark.line + 1) + ": " + one_line(e.msg) +
                                         "; expected a camera calibration in YAML (docs/cameras)"};
  }
}

}  // namespace im2fit::hal
