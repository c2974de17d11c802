// SPDX-License-Identifier: Apache-2.0
#include <cinttypes>
#include <cstdio>
#include <filesystem>

#include "base/file.h"
#include "hal/folder/depth_folder.h"
#include "hal/folder/frame_name.h"
#include "hal/intrinsics.h"

namespace im2fit::hal {
namespace {

Error with_advice(Error error) {
  error.message += "; free some space, or choose a folder you may write to";
  return error;
}

}  // namespace

Result<std::unique_ptr<FolderWriter>> FolderWriter::create(const std::string& path, const Intrinsics& intrinsics,
                                                           const Options& options) {
  if (auto ok = check_intrinsics(intrinsics, "frames to write to " + path); !ok) return ok.error();
  if (!is_rotation(options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  if (auto ok = make_directory(path); !ok) return with_advice(ok.error());
  std::error_code code;
  for (std::filesystem::directory_iterator it(path, code), end; !code && it != end; it.increment(code)) {
    if (frame_number(it->path().filename().string()))
      return Error{ErrorCode::invalid_argument, path + " already holds frames (" + it->path().filename().string() +
                                                    "); choose another folder or delete them"};
  }
  const std::string yaml =
      camera_yaml_text(Calibration{intrinsics, {}, options.rotate_deg, options.origin}, options.camera_name);
  if (auto ok = write_file_atomically(path + "/camera.yaml", yaml); !ok) return with_advice(ok.error());
  return std::unique_ptr<FolderWriter>(new FolderWriter(path, intrinsics, options));
}

FolderWriter::FolderWriter(std::string path, const Intrinsics& intrinsics, const Options& options)
    : path_(std::move(path)), intrinsics_(intrinsics), options_(options) {}

FolderWriter::~FolderWriter() {
  (void)finish();
}

Status FolderWriter::write(DepthView frame, const FrameInfo& info) {
  if (frame.width != intrinsics_.width || frame.height != intrinsics_.height)
    return Error{ErrorCode::invalid_argument,
                 path_ + ": frame to write is " + std::to_string(frame.width) + "x" + std::to_string(frame.height) +
                     ", expected " + std::to_string(intrinsics_.width) + "x" + std::to_string(intrinsics_.height)};
  std::uint64_t number = 0;
  if (!rows_.empty()) {
    const Row& last = rows_.back();
    // A device whose counter restarts is numbered on; its own gaps stay.
    number = last.number + (info.sequence > last.info.sequence ? info.sequence - last.info.sequence : 1);
  }
  auto bytes = encode_depth(frame, options_.format);
  if (!bytes) return bytes.error();
  const std::string path = path_ + "/" + frame_name(number, options_.format);
  if (auto ok = write_file_atomically(path, *bytes); !ok) return with_advice(ok.error());
  rows_.push_back({number, info});
  finished_ = false;
  return Ok{};
}

Status FolderWriter::finish() {
  if (finished_ || rows_.empty()) return Ok{};
  finished_ = true;
  bool device_time = true;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    device_time = device_time && rows_[i].info.device_us >= 0 &&
                  (i == 0 || rows_[i].info.device_us > rows_[i - 1].info.device_us);
  std::string text = device_time ? "frame,host_ns,device_us\n" : "frame,host_ns\n";
  std::int64_t last_ns = INT64_MIN;
  for (const Row& row : rows_) {
    if (row.info.host_ns <= last_ns) return Ok{};  // times that do not grow are no times: 30 fps is assumed instead
    last_ns = row.info.host_ns;
    char line[80];
    std::snprintf(line, sizeof line, "%06" PRIu64 ",%" PRId64, row.number, row.info.host_ns);
    text += line;
    if (device_time) text += "," + std::to_string(row.info.device_us);
    text += "\n";
  }
  if (auto ok = write_file_atomically(path_ + "/timestamps.csv", text); !ok) return with_advice(ok.error());
  return Ok{};
}

}  // namespace im2fit::hal
