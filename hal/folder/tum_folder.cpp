// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/tum_folder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "core/file.h"
#include "core/text.h"
#include "hal/folder/phone_recording.h"
#include "hal/folder/pose_rows.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kTumBytesMax = std::size_t{64} << 20;
constexpr std::size_t kTumRowsMax = 1'000'000;  // the frames a folder may have
constexpr double kTumTimeMaxS = 4e9;            // the year 2096
constexpr double kTumPlaceMaxM = 1000, kTumUnitTolerance = 0.01;
constexpr double kTumPoseGapS = 0.05;  // a walking person's phone moves 5 cm meanwhile, and between two poses less
constexpr Intrinsics kTumLens{640, 480, 525, 525, 319.5F, 239.5F};

// Lines of words between blanks, as both tables have them.
class TumTable {
 public:
  TumTable(std::string_view text, const std::string& what) : rest_(text), what_(what) {}

  // The next row that is not a comment; false at the end.
  bool next(std::vector<std::string>& words) {
    while (!rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      std::string_view line = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++line_;
      words.clear();
      while (words.size() <= kWordsMax) {
        line.remove_prefix(std::min(line.find_first_not_of(" \t\r,"), line.size()));
        if (line.empty() || (words.empty() && line.front() == '#')) break;
        const std::size_t length = std::min(line.find_first_of(" \t\r,"), line.size());
        words.emplace_back(line.substr(0, length));
        line.remove_prefix(length);
      }
      if (!words.empty()) return true;
    }
    return false;
  }
  Error wrong(const std::string& problem) const {
    return {ErrorCode::corrupt, what_ + " line " + std::to_string(line_) + ": " + problem + "; correct the file"};
  }

 private:
  static constexpr std::size_t kWordsMax = 16;
  std::string_view rest_;
  const std::string& what_;
  int line_ = 0;
};

// Of a table's first column, growing.
std::string read_time(NumberReader& numbers, const std::string& word, bool first, double last, double& time_s) {
  if (word.size() > 40 || !numbers.read(word, time_s) || !(time_s >= 0 && time_s <= kTumTimeMaxS))
    return "'" + excerpt(word) + "' is not a time in seconds";
  return first || time_s > last ? "" : "the time is not after that of the row before";
}

// A file that a table may name: within the folder.
bool is_inside(const std::string& file) {
  const std::filesystem::path path(file);
  return !file.empty() && path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
}

// "1305031102.160407.png" -> its time.
std::optional<double> time_named(const std::string& name) {
  if (!name.ends_with(".png") || name.find('.') + 4 == name.size() || name.size() > 40) return std::nullopt;
  double time_s = 0;
  if (!NumberReader().read(name.substr(0, name.size() - 4), time_s) || !(time_s >= 0 && time_s <= kTumTimeMaxS))
    return std::nullopt;
  return time_s;
}

Result<std::vector<TumFrame>> frames_by_name(const std::string& folder) {
  std::vector<TumFrame> frames;
  std::error_code code;
  std::filesystem::directory_iterator it(folder, code);
  for (const std::filesystem::directory_iterator end; !code && it != end; it.increment(code)) {
    const std::string name = it->path().filename().string();
    if (const auto time_s = time_named(name)) frames.push_back({*time_s, "depth/" + name});
    if (frames.size() > kTumRowsMax)
      return Error{ErrorCode::unsupported, folder + " holds more than " + std::to_string(kTumRowsMax) + " frames"};
  }
  if (code) return Error{ErrorCode::io, "cannot read the folder " + folder + ": " + code.message()};
  std::sort(frames.begin(), frames.end(), [](const TumFrame& a, const TumFrame& b) { return a.time_s < b.time_s; });
  return frames;
}

Result<std::string> tum_text(const std::string& path) {
  const auto bytes = read_file(path, kTumBytesMax);
  if (!bytes) return bytes.error();
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

// Between the two poses around the time, or the one beside it.
std::optional<CameraPose> pose_at(const std::vector<TumPose>& poses, double time_s) {
  const auto after = std::lower_bound(poses.begin(), poses.end(), time_s,
                                      [](const TumPose& pose, double time) { return pose.time_s < time; });
  const bool near_after = after != poses.end() && after->time_s - time_s <= kTumPoseGapS;
  if (near_after && after->time_s == time_s) return after->pose;
  const bool near_before = after != poses.begin() && time_s - (after - 1)->time_s <= kTumPoseGapS;
  if (!near_before && !near_after) return std::nullopt;
  if (!near_before) return after->pose;
  if (!near_after) return (after - 1)->pose;
  const CameraPose &a = (after - 1)->pose, &b = after->pose;
  const auto share = static_cast<float>((time_s - (after - 1)->time_s) / (after->time_s - (after - 1)->time_s));
  const float sign = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w < 0 ? -1.0F : 1.0F;  // q and -q turn the same
  const auto mixed = [&](float from, float to) { return from + (sign * to - from) * share; };
  CameraPose mean{mixed(a.x, b.x), mixed(a.y, b.y), mixed(a.z, b.z), mixed(a.w, b.w),
                  a.position_mm + (b.position_mm - a.position_mm) * share};
  const float length = std::sqrt(mean.x * mean.x + mean.y * mean.y + mean.z * mean.z + mean.w * mean.w);
  if (!(length > 0)) return a;
  mean.x /= length;
  mean.y /= length;
  mean.z /= length;
  mean.w /= length;
  return mean;
}

Status take_camera(const std::string& path, const FolderOptions& options, PictureSize size,
                   FolderContents& contents) {
  contents.camera_path = options.camera_yaml_path.empty() ? path + "/camera.yaml" : options.camera_yaml_path;
  if (!options.camera_yaml_path.empty() || file_exists(contents.camera_path)) {
    auto given = load_camera_yaml(contents.camera_path, size);
    if (!given) return given.error();
    contents.camera = *given;
    return Ok{};
  }
  if (size.width != kTumLens.width || size.height != kTumLens.height)
    return Error{ErrorCode::invalid_argument,
                 path + " has pictures of " + std::to_string(size.width) + "x" + std::to_string(size.height) +
                     " and no calibration; give --camera FILE, or put camera.yaml there (docs/cameras)"};
  contents.camera.intrinsics = kTumLens;
  contents.camera.origin = IntrinsicsOrigin::field_of_view;
  return Ok{};
}

}  // namespace

Result<std::vector<TumFrame>> parse_tum_frames(const std::string& text, const std::string& what) {
  TumTable table(text, what);
  NumberReader numbers;
  std::vector<TumFrame> frames;
  for (std::vector<std::string> words; table.next(words);) {
    if (words.size() != 2) return table.wrong("expected a time and the path of a picture");
    TumFrame frame{0, words[1]};
    const std::string fault =
        read_time(numbers, words[0], frames.empty(), frames.empty() ? 0 : frames.back().time_s, frame.time_s);
    if (!fault.empty()) return table.wrong(fault);
    if (!is_inside(frame.file)) return table.wrong("'" + excerpt(frame.file) + "' is not a file within the folder");
    if (frames.size() >= kTumRowsMax) return table.wrong("there are more rows than " + std::to_string(kTumRowsMax));
    frames.push_back(std::move(frame));
  }
  if (frames.empty()) return Error{ErrorCode::corrupt, what + " has no row; copy the recording again"};
  return frames;
}

Result<std::vector<TumPose>> parse_tum_poses(const std::string& text, const std::string& what) {
  TumTable table(text, what);
  NumberReader numbers;
  std::vector<TumPose> poses;
  for (std::vector<std::string> words; table.next(words);) {
    if (words.size() != 8) return table.wrong("expected timestamp tx ty tz qx qy qz qw");
    TumPose row;
    const std::string fault =
        read_time(numbers, words[0], poses.empty(), poses.empty() ? 0 : poses.back().time_s, row.time_s);
    if (!fault.empty()) return table.wrong(fault);
    std::array<double, 7> v{};
    for (std::size_t i = 0; i < v.size(); ++i)
      if (words[i + 1].size() > 40 || !numbers.read(words[i + 1], v[i]) || !std::isfinite(v[i]))
        return table.wrong("'" + excerpt(words[i + 1]) + "' is not a number");
    for (std::size_t i = 0; i < 3; ++i)
      if (!(std::abs(v[i]) <= kTumPlaceMaxM))
        return table.wrong("the place is over a kilometre away; expected metres");
    const double length = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
    if (!(std::abs(length - 1) <= kTumUnitTolerance)) return table.wrong("qx qy qz qw are not a unit quaternion");
    const auto turn = [&](std::size_t i) { return static_cast<float>(v[i] / length); };
    const auto place_mm = [&](std::size_t i) { return static_cast<float>(1000 * v[i]); };
    row.pose = {turn(3), turn(4), turn(5), turn(6), {place_mm(0), place_mm(1), place_mm(2)}};
    if (poses.size() >= kTumRowsMax) return table.wrong("there are more rows than " + std::to_string(kTumRowsMax));
    poses.push_back(row);
  }
  return poses;
}

bool is_tum_folder(const std::string& path) {
  std::error_code code;
  std::filesystem::directory_iterator it(path + "/depth", code);
  if (code) return false;
  if (file_exists(path + "/depth.txt")) return true;  // beside numbered pictures alone it is somebody's note
  for (; it != std::filesystem::directory_iterator(); it.increment(code))
    if (code || time_named(it->path().filename().string())) return !code;
  return false;
}

Result<std::unique_ptr<FolderSource>> open_tum_folder(const std::string& path, const FolderOptions& options) {
  FolderContents contents;
  contents.table_path = path + "/depth.txt";
  const bool has_list = file_exists(contents.table_path);
  Result<std::vector<TumFrame>> frames = std::vector<TumFrame>();
  if (has_list) {
    const auto text = tum_text(contents.table_path);
    if (!text) return text.error();
    frames = parse_tum_frames(*text, contents.table_path);
  } else {
    frames = frames_by_name(path + "/depth");
  }
  if (!frames) return frames.error();
  std::vector<TumPose> poses;
  if (const std::string table = path + "/groundtruth.txt"; file_exists(table)) {
    const auto text = tum_text(table);
    if (!text) return text.error();
    auto rows = parse_tum_poses(*text, table);
    if (!rows) return rows.error();
    poses = std::move(*rows);
  }
  for (const TumFrame& frame : *frames) {
    FrameInfo info;
    info.sequence = contents.listed.size();
    info.host_ns = std::llround(frame.time_s * 1e9);
    info.device_us = std::llround(frame.time_s * 1e6);
    info.pose = pose_at(poses, frame.time_s);
    contents.listed.push_back({path + "/" + frame.file, info});
  }
  std::vector<std::byte> bytes;
  PictureSize size;
  Result<DepthHeader> header = Error{ErrorCode::not_found, path + " holds no pictures"};
  for (const auto& listed : contents.listed) {
    if (auto ok = read_file_into(listed.path, kTumBytesMax, kHeaderBytes, bytes); !ok) return ok.error();
    auto one = parse_depth_header(bytes, listed.path);
    if (one || one.error().code != ErrorCode::corrupt || header.error().code == ErrorCode::not_found) header = one;
    if (one || one.error().code != ErrorCode::corrupt) break;
  }
  if (!header) return header.error();
  size = {header->width, header->height};
  if (auto ok = take_camera(path, options, size, contents); !ok) return ok.error();
  FolderOptions with_contents = options;
  with_contents.contents = &contents;
  if (options.unit_mm == 0) with_contents.unit_mm = kTumUnitMm;
  return FolderSource::open(path, with_contents);
}

}  // namespace im2fit::hal
