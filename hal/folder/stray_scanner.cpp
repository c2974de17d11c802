// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/stray_scanner.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "core/file.h"
#include "hal/folder/phone_recording.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kMatrixBytesMax = 4096;

Result<PinholeLens> read_matrix(const std::string& path) {
  const auto bytes = read_file(path, kMatrixBytesMax);
  if (!bytes) return bytes.error();
  const auto matrix = matrix_in({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  const auto lens = matrix ? pinhole_lens(*matrix) : std::nullopt;
  if (lens && (*lens)[0] > 0 && (*lens)[1] > 0) return *lens;
  return Error{ErrorCode::corrupt,
               path + " is not a matrix fx, 0, cx / 0, fy, cy / 0, 0, 1; copy the recording again"};
}

}  // namespace

bool is_stray_scanner(const std::string& path) {
  std::error_code code;
  return std::filesystem::is_directory(path + "/depth", code) && !file_exists(path + "/camera.yaml") &&
         (file_exists(path + "/odometry.csv") || file_exists(path + "/camera_matrix.csv"));
}

Result<std::unique_ptr<FolderSource>> open_stray_scanner(const std::string& path, const FolderOptions& options) {
  PhoneRecording recording;
  recording.path = path;
  FolderContents& contents = recording.contents;
  contents.frames_path = path + "/depth";
  contents.table_path = path + "/odometry.csv";
  if (file_exists(path + "/confidence")) contents.confidence_path = path + "/confidence";
  auto size = first_depth_size(contents.frames_path);
  if (!size) return size.error();
  recording.size = std::move(*size);
  if (file_exists(contents.table_path)) {
    auto read = read_pose_rows(contents.table_path, PoseTable::odometry_csv);
    if (!read) return read.error();
    recording.rows = std::move(*read);
    if (recording.rows.empty())
      return Error{ErrorCode::corrupt, contents.table_path + " has no row; copy the whole recording again"};
  }
  recording.lens_path = path + "/camera_matrix.csv";
  if (options.camera_yaml_path.empty()) {
    const auto matrix = read_matrix(recording.lens_path);
    if (!matrix && matrix.error().code == ErrorCode::not_found)
      return Error{ErrorCode::not_found,
                   recording.lens_path + " is missing; copy the whole recording again, or give --camera FILE"};
    if (!matrix) return matrix.error();
    recording.colour_lens = *matrix;
  }
  return open_phone_recording(std::move(recording), options);
}

}  // namespace im2fit::hal
