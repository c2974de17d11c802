// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/camera_yaml.h"

#include <yaml-cpp/yaml.h>

#include <charconv>
#include <cstddef>
#include <vector>

#include "core/file.h"
#include "core/text.h"
#include "hal/intrinsics.h"

namespace im2fit::hal {
namespace {

Error lacks(const std::string& path, const std::string& key, const std::string& expected) {
  return {ErrorCode::invalid_argument, path + ": " + key + " is missing or not " + expected +
                                           "; write it as ROS or OpenCV calibration does (docs/cameras)"};
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

// ROS's name for five coefficients, as RealSense's own programs have it.
bool is_known_model(const std::string& name) {
  return name == "plumb_bob" || name == "rational_polynomial" || name == "Brown Conrady";
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
  if (!is_known_model(name))
    return Error{ErrorCode::unsupported, path + ": distortion_model is " + name + ", expected plumb_bob or " +
                                             "rational_polynomial; undistort the pictures and write zeros"};
  return Ok{};
}

// The same in the words of ROS's calibration file, from those of others. Where a key of theirs is absent the other is
// left out, and its absence is what is reported.
//   ros2 topic echo (camera_info):  width height k: [9] d: [...] distortion_model     (ROS 1: K, D)
//   Open3D:                         width height intrinsic_matrix: [9, column by column]
//   RealSense, Orbbec, others:      width height fx fy (ppx ppy | cx cy) (coeffs), flat or below one of kGroups
YAML::Node in_ros_words(const YAML::Node& root) {
  constexpr const char* kGroups[] = {"depth", "depth_intrinsics", "depth_intrinsic", "intrinsics", "intrinsic"};
  if (!root.IsMap() || root["image_width"].IsDefined() || root["camera_matrix"].IsDefined()) return root;
  for (const char* group : kGroups)
    if (root[group].IsDefined() && root[group].IsMap()) return in_ros_words(root[group]);
  YAML::Node out;
  for (const auto& [from, to] : {std::pair{"width", "image_width"},
                                 {"height", "image_height"},
                                 {"k", "camera_matrix"},
                                 {"K", "camera_matrix"},
                                 {"d", "distortion_coefficients"},
                                 {"D", "distortion_coefficients"},
                                 {"coeffs", "distortion_coefficients"},
                                 {"distortion_model", "distortion_model"},
                                 {"im2fit_rotate_deg", "im2fit_rotate_deg"},
                                 {"im2fit_confidence_min", "im2fit_confidence_min"}})
    if (root[from].IsDefined()) out[to] = root[from];
  const YAML::Node columns = root["intrinsic_matrix"];
  if (columns.IsDefined() && columns.IsSequence() && columns.size() == 9)
    for (std::size_t i = 0; i < 9; ++i) out["camera_matrix"].push_back(columns[3 * (i % 3) + i / 3]);
  const char* cx = root["ppx"].IsDefined() ? "ppx" : "cx";
  const char* cy = root["ppy"].IsDefined() ? "ppy" : "cy";
  bool all = true;
  for (const char* key : {"fx", "fy", cx, cy}) all = all && root[key].IsDefined();
  if (!all) return out;
  YAML::Node matrix;
  for (int i = 0; i < 9; ++i) matrix.push_back(0);
  matrix[0] = root["fx"];
  matrix[2] = root[cx];
  matrix[4] = root["fy"];
  matrix[5] = root[cy];
  matrix[8] = 1;
  out["camera_matrix"] = matrix;
  return out;
}

Result<CameraFile> interpret(const YAML::Node& file_root, const std::string& path) {
  const YAML::Node root = in_ros_words(file_root);
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
                 path + ": camera_matrix has skew or is not a pinhole matrix; expected [fx,0,cx, 0,fy,cy, 0,0,1]"};
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
  if (root["im2fit_confidence_min"].IsDefined()) {
    file.confidence_min = root["im2fit_confidence_min"].as<int>();
    if (*file.confidence_min < 0 || *file.confidence_min > 255)
      return lacks(path, "im2fit_confidence_min", "a whole number from 0 to 255");
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
  const auto bytes = read_file(path, kTextBytesMax);
  if (!bytes) return bytes.error();
  return parse_camera_yaml(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()), path);
}

Result<CameraFile> parse_camera_yaml(const std::string& text, const std::string& path) {
  try {
    auto file = interpret(YAML::Load(without_directive(text)), path);
    if (!file) return Error{file.error().code, printable(file.error().message)};
    return file;
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::corrupt, path + " line " + std::to_string(e.mark.line + 1) + ": " + printable(e.msg) +
                                         "; expected a camera calibration in YAML (docs/cameras)"};
  }
}

}  // namespace im2fit::hal
