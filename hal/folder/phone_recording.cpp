// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/phone_recording.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "core/file.h"
#include "hal/folder/frame_name.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kPictureBytesMax = std::size_t{64} << 20;  // as FolderSource's
constexpr std::int64_t kFrameNs = 1'000'000'000 / 60;            // ARKit's rate, where no table has the times
// A phone that is held upright: its camera's x axis points down.
constexpr int kPortraitDeg = 90;

// The camera focuses while it records, and the matrix is the last frame's alone.
PinholeLens mean_lens(const std::vector<PoseRow>& rows, const PinholeLens& matrix) {
  PinholeLens sum{};
  for (const PoseRow& row : rows) {
    if (!row.lens) return matrix;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>((*row.lens)[i]);
  }
  if (rows.empty()) return matrix;
  for (double& value : sum) value /= static_cast<double>(rows.size());
  return sum;
}

// For messages: a file may have any number.
std::string whole(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

// Of depth pictures as the phone stores them, in landscape.
Result<Intrinsics> scaled(const PinholeLens& lens, int width, int height, const std::string& matrix_path) {
  if (!is_centred(lens, kPhoneColourWidth, kPhoneColourHeight))
    return Error{ErrorCode::invalid_argument,
                 matrix_path + " has its centre at (" + whole(lens[2]) + ", " + whole(lens[3]) +
                     "), expected near (960, 720) of a 1920x1440 picture; give the depth camera's calibration by "
                     "--camera FILE"};
  const PinholeLens own = scaled_lens(lens, static_cast<double>(width) / kPhoneColourWidth);
  const auto at = [&](std::size_t i) { return static_cast<float>(own[i]); };
  return Intrinsics{width, height, at(0), at(1), at(2), at(3)};
}

// ARKit's world has y up. The inverse of a unit quaternion turns it into the camera's axes.
Vec3f down_seen(const CameraPose& q) {
  return {-2 * (q.x * q.y + q.z * q.w), -(1 - 2 * (q.x * q.x + q.z * q.z)), -2 * (q.y * q.z - q.x * q.w)};
}

int upright_rotation(Vec3f down) {
  int best = 0;
  for (const int turned : {90, 180, 270})
    if (rotate_upright(down, turned).y > rotate_upright(down, best).y) best = turned;
  return best;
}

// `turned`: by how much the pictures were turned after the phone stored them.
void take_rows(const std::vector<PoseRow>& rows, int turned, FolderContents& contents) {
  for (const PoseRow& row : rows) {
    FrameInfo info;
    info.sequence = row.sequence;
    info.host_ns = row.time_s ? std::llround(*row.time_s * 1e9) : static_cast<std::int64_t>(row.sequence) * kFrameNs;
    if (row.time_s) info.device_us = std::llround(*row.time_s * 1e6);
    info.pose = rotate_upright(row.pose, turned);
    info.down = rotate_upright(normalized(down_seen(row.pose)), turned);
    contents.frames.emplace(row.sequence, info);
  }
}

Status take_lens(PhoneRecording& recording, int turned) {
  const auto& [header, picture] = recording.size;
  const int wide = std::max(header.width, header.height), high = std::min(header.width, header.height);
  if (wide * kPhoneColourHeight != high * kPhoneColourWidth)
    return Error{ErrorCode::invalid_argument, picture + " is " + std::to_string(header.width) + "x" +
                                                  std::to_string(header.height) +
                                                  ", expected sides of 4 to 3 as the picture of " +
                                                  std::filesystem::path(recording.lens_path).filename().string() +
                                                  " has; copy the recording again, or give --camera FILE"};
  const auto k = scaled(mean_lens(recording.rows, recording.colour_lens), wide, high, recording.lens_path);
  if (!k) return k.error();
  recording.contents.camera.intrinsics = rotate_upright(*k, turned);
  recording.contents.camera.origin = IntrinsicsOrigin::recording;
  return Ok{};
}

}  // namespace

bool file_exists(const std::string& path) {
  std::error_code code;
  return std::filesystem::exists(path, code) || code;
}

Result<std::pair<DepthHeader, std::string>> first_depth_size(const std::string& folder) {
  std::error_code code;
  std::vector<std::pair<std::uint64_t, std::string>> pictures;
  bool npy = false;
  std::filesystem::directory_iterator it(folder, code);
  for (const std::filesystem::directory_iterator end; !code && it != end; it.increment(code)) {
    const std::string name = it->path().filename().string();
    npy = npy || name.ends_with(".npy");
    if (const auto number = frame_number(name)) pictures.emplace_back(*number, folder + "/" + name);
  }
  if (code) return Error{ErrorCode::io, "cannot read the folder " + folder + ": " + code.message()};
  if (pictures.empty() && npy)
    return Error{ErrorCode::unsupported, folder +
                                             " holds .npy files of the app's first versions; convert them to 16-bit "
                                             "PNG in millimetres, named 000000.png"};
  if (pictures.empty())
    return Error{ErrorCode::not_found, folder + " holds no 000000.png; copy the whole recording again"};
  std::sort(pictures.begin(), pictures.end());
  std::vector<std::byte> bytes;
  std::optional<Error> first;
  for (const auto& [number, path] : pictures) {
    if (auto ok = read_file_into(path, kPictureBytesMax, kHeaderBytes, bytes); !ok) return ok.error();
    const auto header = parse_depth_header(bytes, path);
    if (header) return std::pair(*header, path);
    if (header.error().code != ErrorCode::corrupt) return header.error();
    if (!first) first = header.error();
  }
  return *first;
}

Result<std::unique_ptr<FolderSource>> open_phone_recording(PhoneRecording recording, const FolderOptions& options) {
  FolderContents& contents = recording.contents;
  const auto [width, height] = std::pair(recording.size.first.width, recording.size.first.height);
  const std::vector<PoseRow>& rows = recording.rows;
  contents.sensor = SensorKind::time_of_flight;
  const int turned = width < height ? kPortraitDeg : 0;
  contents.camera_path = options.camera_yaml_path.empty() ? recording.lens_path : options.camera_yaml_path;
  if (!options.camera_yaml_path.empty()) {
    auto given = load_camera_yaml(options.camera_yaml_path, {width, height});
    if (!given) return given.error();
    contents.camera = *given;
  } else if (auto ok = take_lens(recording, turned); !ok) {
    return ok.error();
  }
  const int held_deg = rows.empty() ? kPortraitDeg : upright_rotation(down_seen(rows.front().pose));
  if (!contents.camera.rotate_deg) contents.camera.rotate_deg = (held_deg - turned + 360) % 360;
  take_rows(rows, turned, contents);
  contents.frame_ns = kFrameNs;
  FolderOptions with_contents = options;
  with_contents.contents = &contents;
  return FolderSource::open(recording.path, with_contents);
}

}  // namespace im2fit::hal
