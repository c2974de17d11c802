// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/scanner_3d_app.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/file.h"
#include "core/text.h"
#include "hal/folder/calibration_text.h"
#include "hal/folder/frame_name.h"
#include "hal/folder/phone_recording.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kAppFrameBytesMax = 64 * 1024;  // a few hundred numbers
constexpr std::size_t kAppFramesMax = 100'000;        // half an hour; each has a file of its own that is read first
constexpr double kAppPlaceMaxM = 1000, kAppTimeMaxS = 4e9, kTurnTolerance = 0.01;

// "frame_00012.json" -> 12.
std::optional<std::uint64_t> app_frame_number(const std::string& name) {
  constexpr std::string_view kHead = "frame_", kEnd = ".json";
  if (!name.starts_with(kHead) || !name.ends_with(kEnd)) return std::nullopt;
  return frame_number(name.substr(0, name.size() - kEnd.size()) + ".png");
}

// The files by their numbers. Error: io, unsupported.
Result<std::map<std::uint64_t, std::string>> app_frames(const std::string& path) {
  std::map<std::uint64_t, std::string> files;
  std::error_code code;
  std::filesystem::directory_iterator it(path, code);
  for (const std::filesystem::directory_iterator end; !code && it != end; it.increment(code)) {
    if (const auto number = app_frame_number(it->path().filename().string()))
      files.emplace(*number, it->path().string());
    if (files.size() > kAppFramesMax)
      return Error{ErrorCode::unsupported, path + " holds more than " + std::to_string(kAppFramesMax) + " frames"};
  }
  if (code) return Error{ErrorCode::io, "cannot read the folder " + path + ": " + code.message()};
  return files;
}

// [row][column] of a rotation, to a unit quaternion.
CameraPose turned_as(const std::array<std::array<double, 3>, 3>& m) {
  const std::array<double, 4> four = {1 + m[0][0] - m[1][1] - m[2][2], 1 - m[0][0] + m[1][1] - m[2][2],
                                      1 - m[0][0] - m[1][1] + m[2][2], 1 + m[0][0] + m[1][1] + m[2][2]};
  const auto most = static_cast<std::size_t>(std::max_element(four.begin(), four.end()) - four.begin());
  const std::array<double, 3> sums = {m[2][1] + m[1][2], m[0][2] + m[2][0], m[1][0] + m[0][1]};
  const std::array<double, 3> differences = {m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]};
  std::array<double, 4> q{};
  if (most == 3) {
    q = {differences[0], differences[1], differences[2], four[3]};
  } else {
    for (std::size_t i = 0; i < 3; ++i) q[i] = i == most ? four[most] : sums[3 - i - most];
    q[3] = differences[most];
  }
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const auto part = [&](std::size_t i) { return static_cast<float>(q[i] / length); };
  return {part(0), part(1), part(2), part(3), {}};
}

template <std::size_t kCount>
std::optional<std::array<double, kCount>> numbers_under(const YAML::Node& root, const char* key) {
  const YAML::Node list = root[key];
  if (!list.IsDefined() || !list.IsSequence() || list.size() != kCount) return std::nullopt;
  std::array<double, kCount> numbers{};
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!list[i].IsScalar() || !YAML::convert<double>::decode(list[i], numbers[i]) || !std::isfinite(numbers[i]))
      return std::nullopt;
  }
  return numbers;
}

Result<PoseRow> app_frame(const YAML::Node& root, const std::string& path) {
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorCode::corrupt, path + ": " + what + "; export the recording again"};
  };
  if (!root.IsMap()) return wrong("is not a frame of 3D Scanner App");
  PoseRow row;
  const auto matrix = numbers_under<9>(root, "intrinsics");
  const auto lens = matrix ? pinhole_lens(*matrix) : std::nullopt;
  if (!lens || !((*lens)[0] > 0 && (*lens)[1] > 0)) return wrong("intrinsics is missing or not a 3 x 3 matrix");
  row.lens.emplace();
  for (std::size_t i = 0; i < lens->size(); ++i) (*row.lens)[i] = static_cast<float>((*lens)[i]);
  const auto pose = numbers_under<16>(root, "cameraPoseARFrame");
  if (!pose || (*pose)[12] != 0 || (*pose)[13] != 0 || (*pose)[14] != 0 || (*pose)[15] != 1)
    return wrong("cameraPoseARFrame is missing or not a 4 x 4 matrix, row by row");
  // ARKit's camera has y up and z backwards.
  std::array<std::array<double, 3>, 3> axes{};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c) axes[r][c] = (c == 0 ? 1 : -1) * (*pose)[4 * r + c];
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 3; ++b) {
      const double product = axes[0][a] * axes[0][b] + axes[1][a] * axes[1][b] + axes[2][a] * axes[2][b];
      if (!(std::abs(product - (a == b ? 1 : 0)) < kTurnTolerance))
        return wrong("cameraPoseARFrame is not a rotation");
    }
  row.pose = turned_as(axes);
  std::array<float, 3> place{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double metres = (*pose)[4 * i + 3];
    if (!(std::abs(metres) <= kAppPlaceMaxM)) return wrong("cameraPoseARFrame is over a kilometre away");
    place[i] = static_cast<float>(1000 * metres);
  }
  row.pose.position_mm = {place[0], place[1], place[2]};
  const YAML::Node time = root["time"];
  double seconds = 0;
  if (!time.IsDefined() || !time.IsScalar() || !YAML::convert<double>::decode(time, seconds) ||
      !(seconds >= 0 && seconds <= kAppTimeMaxS))
    return wrong("time is missing or not a time in seconds");
  row.time_s = seconds;
  return row;
}

}  // namespace

Result<PoseRow> parse_app_frame(const std::string& text, const std::string& path) {
  try {
    const auto tree = calibration_tree(text, path);
    if (!tree) return tree.error();
    return app_frame(*tree, path);
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::corrupt, path + " line " + std::to_string(e.mark.line + 1) + ": " + printable(e.msg) +
                                         "; export the recording again"};
  }
}

bool is_scanner_3d_app(const std::string& path) {
  if (file_exists(path + "/camera.yaml")) return false;
  std::error_code code;
  std::filesystem::directory_iterator it(path, code);
  for (const std::filesystem::directory_iterator end; !code && it != end; it.increment(code)) {
    const std::string name = it->path().filename().string();
    if (!app_frame_number(name)) continue;
    const std::string digits = name.substr(6, name.size() - 11);
    if (file_exists(path + "/depth_" + digits + ".png")) return true;
  }
  return false;
}

Result<std::unique_ptr<FolderSource>> open_scanner_3d_app(const std::string& path, const FolderOptions& options) {
  PhoneRecording recording;
  recording.path = recording.contents.frames_path = path;
  auto size = first_depth_size(path);
  if (!size) return size.error();
  recording.size = std::move(*size);
  const auto files = app_frames(path);
  if (!files) return files.error();
  for (const auto& [number, file] : *files) {
    const std::string name = std::filesystem::path(file).filename().string();
    const std::string digits = name.substr(6, name.size() - 11);
    if (!file_exists(path + "/depth_" + digits + ".png")) continue;  // the app keeps depth of some frames only
    if (file_exists(path + "/conf_" + digits + ".png")) recording.contents.confidence_beside = true;
    const auto bytes = read_file(file, kAppFrameBytesMax);
    if (!bytes) return bytes.error();
    auto row = parse_app_frame({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, file);
    if (!row) return row.error();
    row->sequence = number;
    if (!recording.rows.empty() && !(*row->time_s > *recording.rows.back().time_s))
      return Error{ErrorCode::corrupt,
                   file + ": time is not after that of the frame before; export the recording again"};
    recording.rows.push_back(*row);
  }
  recording.contents.table_path = path + "/frame_NNNNN.json";
  recording.lens_path = files->empty() ? path : files->begin()->second;
  return open_phone_recording(std::move(recording), options);
}

}  // namespace im2fit::hal
