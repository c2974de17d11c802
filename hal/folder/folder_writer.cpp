// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/file.h"
#include "hal/folder/depth_folder.h"
#include "hal/folder/frame_name.h"
#include "hal/folder/pose_rows.h"
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
  // Of frames that were deleted: a reader would take them for these frames'.
  for (const char* name : {"poses.csv", "confidence"})
    if (std::filesystem::exists(path + "/" + name, code))
      return Error{ErrorCode::invalid_argument,
                   path + " already holds " + name + "; choose another folder or delete it"};
  const std::string yaml =
      camera_yaml_text(Calibration{intrinsics, {}, options.rotate_deg, options.origin}, options.camera_name);
  // The camera's, not a person's: a service may read it as its calibration.
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
  Row row{0, info};
  if (!rows_.empty()) {
    const Row& last = rows_.back();
    // A device whose counter restarts is numbered on; its own gaps stay.
    row.number = last.number + (info.sequence > last.info.sequence ? info.sequence - last.info.sequence : 1);
  }
  auto bytes = encode_depth(frame, options_.format);
  if (!bytes) return bytes.error();
  // The rows first: one without its frame is not missed, a frame without its row is.
  auto written = note_times(row);
  if (written) written = note_pose(row);
  if (written)
    written =
        write_file_atomically(path_ + "/" + frame_name(row.number, options_.format), *bytes, Readable::by_owner);
  if (!written) {
    take_back();
    return with_advice(written.error());
  }
  rows_.push_back(row);
  if (row.info.pose) ++poses_count_;
  times_.keep();
  poses_.keep();
  return Ok{};
}

Status FolderWriter::note_times(const Row& row) {
  if (!host_times_) return Ok{};
  if (rows_.empty()) {
    device_times_ = row.info.device_us >= 0;
    downs_ = row.info.down.has_value();
  } else if (row.info.host_ns <= rows_.back().info.host_ns) {
    host_times_ = false;  // 30 fps is assumed instead
    times_.close();
    ::unlink(times_path().c_str());
    return Ok{};
  } else if (device_times_ && row.info.device_us <= rows_.back().info.device_us) {
    device_times_ = false;
    times_.close();
  }
  if (row.info.down && !downs_) {
    downs_ = true;
    times_.close();
  }
  if (times_.fd < 0)
    if (auto ok = rewrite_times(); !ok) return ok;
  return times_.append(times_path(), line_of(row));
}

// The header and the rows so far, then open for more.
Status FolderWriter::rewrite_times() {
  std::string text = "frame,host_ns";
  if (device_times_) text += ",device_us";
  if (downs_) text += ",down_x,down_y,down_z";
  text += "\n";
  for (const Row& row : rows_) text += line_of(row);
  return times_.begin(times_path(), text);
}

Status FolderWriter::note_pose(const Row& row) {
  if (!row.info.pose) return Ok{};
  if (poses_.fd < 0)
    if (auto ok = poses_.begin(poses_path(), kPosesHeader); !ok) return ok;
  return poses_.append(poses_path(), poses_line(row.number, *row.info.pose));
}

std::string FolderWriter::line_of(const Row& row) const {
  char line[80];
  std::snprintf(line, sizeof line, "%06" PRIu64 ",%" PRId64, row.number, row.info.host_ns);
  std::string text = line;
  if (device_times_) text += "," + std::to_string(row.info.device_us);
  if (downs_ && !row.info.down) text += ",,,";
  if (downs_ && row.info.down) {
    const Vec3f down = *row.info.down;  // nine digits give a float back to the bit
    std::snprintf(line, sizeof line, ",%.9g,%.9g,%.9g", static_cast<double>(down.x), static_cast<double>(down.y),
                  static_cast<double>(down.z));
    text += line;
  }
  return text + "\n";
}

Status FolderWriter::Table::begin(const std::string& path, const std::string& text) {
  if (auto ok = write_file_atomically(path, text, Readable::by_owner); !ok) return ok;
  fd = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (fd < 0) return Error{ErrorCode::io, "cannot write " + path + ": " + std::strerror(errno)};
  bytes = static_cast<std::int64_t>(text.size());
  return Ok{};
}

Status FolderWriter::Table::append(const std::string& path, const std::string& line) {
  const ssize_t count = ::write(fd, line.data(), line.size());
  if (count == static_cast<ssize_t>(line.size())) return Ok{};
  return Error{ErrorCode::io, "cannot write " + path + ": " + std::strerror(count < 0 ? errno : ENOSPC)};
}

void FolderWriter::Table::keep() {
  struct stat about {};
  if (fd >= 0 && ::fstat(fd, &about) == 0) bytes = about.st_size;
}

void FolderWriter::Table::take_back() {
  if (fd < 0) return;
  [[maybe_unused]] const int cut = ::ftruncate(fd, static_cast<off_t>(bytes));
}

void FolderWriter::Table::close() {
  if (fd >= 0) ::close(std::exchange(fd, -1));
}

// The rows of a frame that failed; a table that has no others goes with them.
void FolderWriter::take_back() {
  times_.take_back();
  poses_.take_back();
  if (rows_.empty() && times_.fd >= 0) {
    times_.close();
    ::unlink(times_path().c_str());
  }
  if (poses_count_ == 0 && poses_.fd >= 0) {
    poses_.close();
    ::unlink(poses_path().c_str());
  }
}

Status FolderWriter::finish() {
  Status done = Ok{};
  for (const auto& [table, path] : {std::pair{&times_, times_path()}, {&poses_, poses_path()}}) {
    if (table->fd < 0) continue;
    const int fd = std::exchange(table->fd, -1);
    const bool synced = ::fsync(fd) == 0;
    const int code = errno;
    if ((::close(fd) == 0 && synced) || !done) continue;
    done = with_advice(Error{ErrorCode::io, "cannot write " + path + ": " + std::strerror(synced ? errno : code)});
  }
  return done;
}

}  // namespace im2fit::hal
