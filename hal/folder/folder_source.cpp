// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>

#include "core/file.h"
#include "hal/folder/camera_yaml.h"
#include "hal/folder/depth_folder.h"
#include "hal/folder/frame_name.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kFramesMax = 1'000'000;
constexpr off_t kFileBytesMax = 64 << 20;  // 2048 x 2048 pixels are 8 MB; a PNG can hardly be eight times larger

std::int64_t frame_time_ns(std::uint64_t sequence) {
  return static_cast<std::int64_t>(sequence) * 1'000'000'000 / 30;
}

Error cannot_read(const std::string& path) {
  const int code = errno;
  return {code == ENOENT ? ErrorCode::not_found : ErrorCode::io, "cannot read " + path + ": " + std::strerror(code)};
}

// Reads at most `limit` bytes into `bytes`, whose memory is kept from frame to frame.
Status read_into(const std::string& path, std::size_t limit, std::vector<std::byte>& bytes) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return cannot_read(path);
  struct stat info {};
  Status status = Ok{};
  if (::fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
    status = Error{ErrorCode::io, path + " is not a regular file"};
  } else if (info.st_size > kFileBytesMax) {
    status = Error{ErrorCode::unsupported, path + " is larger than 64 MiB; expected one 16-bit depth picture"};
  } else {
    bytes.resize(std::min(limit, static_cast<std::size_t>(info.st_size)));
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t n = ::read(fd, bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) status = cannot_read(path);
      if (n <= 0) break;
      done += static_cast<std::size_t>(n);
    }
    bytes.resize(done);
  }
  ::close(fd);
  return status;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  std::istringstream stream(line);
  while (std::getline(stream, cell, ',')) {
    const auto begin = cell.find_first_not_of(" \t\r");
    const auto end = cell.find_last_not_of(" \t\r");
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
  }
  return cells;
}

bool to_number(const std::string& text, std::int64_t& value) {
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  return code == std::errc() && end == text.data() + text.size();
}

struct Times {
  std::int64_t host_ns = -1;
  std::int64_t device_us = -1;
};

// The columns of timestamps.csv by the names in its first line.
struct Columns {
  std::array<std::size_t, 3> at = {SIZE_MAX, SIZE_MAX, SIZE_MAX};
  static constexpr std::array<const char*, 3> kNames = {"frame", "host_ns", "device_us"};
  explicit Columns(const std::string& header) {
    const auto cells = split(header);
    for (std::size_t column = 0; column < kNames.size(); ++column) {
      const auto it = std::find(cells.begin(), cells.end(), kNames[column]);
      if (it != cells.end()) at[column] = static_cast<std::size_t>(it - cells.begin());
    }
  }
  bool usable() const { return at[0] != SIZE_MAX && (at[1] != SIZE_MAX || at[2] != SIZE_MAX); }
};

Result<std::map<std::int64_t, Times>> parse_times(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  std::istringstream text(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
  std::string line;
  std::getline(text, line);
  const Columns columns(line);
  if (!columns.usable())
    return Error{ErrorCode::corrupt,
                 path + " line 1: expected column names frame and host_ns or device_us; correct or delete the file"};
  std::map<std::int64_t, Times> times;
  // A recorder that was stopped short may have left a piece of a row at the end; its frame was not yet written.
  const bool whole = bytes->empty() || bytes->back() == std::byte{'\n'};
  std::array<std::int64_t, 3> last = {-1, INT64_MIN, INT64_MIN};
  for (int number = 2; std::getline(text, line); ++number) {
    const auto cells = split(line);
    if (cells.empty() || (cells.size() == 1 && cells[0].empty())) continue;
    std::array<std::int64_t, 3> values = {-1, -1, -1};
    if (!whole && text.eof() && cells.size() < 2) break;
    for (std::size_t column = 0; column < values.size(); ++column) {
      if (columns.at[column] == SIZE_MAX) continue;
      const std::string where = path + " line " + std::to_string(number) + ": " + Columns::kNames[column];
      if (columns.at[column] >= cells.size() || !to_number(cells[columns.at[column]], values[column]))
        return Error{ErrorCode::corrupt, where + " is missing or no whole number; correct or delete the file"};
      if (values[column] <= last[column])
        return Error{ErrorCode::corrupt,
                     where + " is " + std::to_string(values[column]) + ", not after " + std::to_string(last[column]) +
                         " of the row before; put the frames in order of time, or delete the file"};
      last[column] = values[column];
    }
    times[values[0]] = {values[1], values[2]};
  }
  return times;
}

}  // namespace

Result<std::unique_ptr<FolderSource>> FolderSource::open(const std::string& path, const FolderOptions& options) {
  std::unique_ptr<FolderSource> source(new FolderSource);
  if (options.rotate_deg && !is_rotation(*options.rotate_deg))
    return Error{ErrorCode::invalid_argument,
                 "rotation is " + std::to_string(*options.rotate_deg) + ", expected 0, 90, 180 or 270 degrees"};
  if (auto ok = source->scan(path); !ok) return ok.error();
  const std::string yaml = options.camera_yaml_path.empty() ? path + "/camera.yaml" : options.camera_yaml_path;
  auto camera = load_camera_yaml(yaml);
  if (!camera) {
    Error error = camera.error();
    if (error.code == ErrorCode::not_found)
      error.message = yaml + " is missing; put the camera's calibration there or give --camera FILE (docs/cameras)";
    return error;
  }
  if (auto ok = source->check_frames(camera->intrinsics); !ok) return ok.error();
  if (std::filesystem::exists(path + "/timestamps.csv")) {
    if (auto ok = source->read_timestamps(path + "/timestamps.csv"); !ok) return ok.error();
  }
  SourceInfo& info = source->info_;
  info.uri = path;
  info.name = path;
  info.rotate_deg = options.rotate_deg.value_or(camera->rotate_deg.value_or(0));
  info.intrinsics_origin = camera->origin;
  info.frame_count = static_cast<std::int64_t>(source->frames_.size());
  auto upright = UprightPath::make(*camera, info.rotate_deg, yaml);
  if (!upright) return upright.error();
  source->path_ = std::move(*upright);
  info.intrinsics = source->path_.upright();
  return source;
}

Status FolderSource::scan(const std::string& path) {
  std::error_code code;
  std::filesystem::directory_iterator it(path, code);
  if (code)
    return Error{code == std::errc::no_such_file_or_directory ? ErrorCode::not_found : ErrorCode::io,
                 "cannot read the folder " + path + ": " + code.message()};
  for (const std::filesystem::directory_iterator end; !code && it != end; it.increment(code)) {
    const auto number = frame_number(it->path().filename().string());
    if (!number) continue;
    Frame frame{it->path().string(), {*number, frame_time_ns(*number), -1}};
    frames_.push_back(std::move(frame));
    if (frames_.size() > kFramesMax)
      return Error{ErrorCode::unsupported, path + " holds more than " + std::to_string(kFramesMax) + " frames"};
  }
  if (code) return Error{ErrorCode::io, "cannot read the folder " + path + ": " + code.message()};
  if (frames_.empty())
    return Error{ErrorCode::not_found, path +
                                           " holds no depth frames; expected 16-bit files named 000000.png or "
                                           "000000.pgm, 000001.png ..."};
  std::sort(frames_.begin(), frames_.end(),
            [](const Frame& a, const Frame& b) { return a.info.sequence < b.info.sequence; });
  for (std::size_t i = 1; i < frames_.size(); ++i) {
    if (frames_[i].info.sequence == frames_[i - 1].info.sequence)
      return Error{ErrorCode::invalid_argument, frames_[i - 1].path + " and " + frames_[i].path +
                                                    " have the same frame number; remove one of them"};
  }
  return Ok{};
}

Status FolderSource::check_frames(const Intrinsics& camera) const {
  std::vector<std::byte> bytes;
  for (const Frame& frame : frames_) {
    if (auto ok = read_into(frame.path, kHeaderBytes, bytes); !ok) return ok.error();
    const auto header = parse_depth_header(bytes, frame.path);
    if (!header) return header.error();
    if (header->width == camera.width && header->height == camera.height) continue;
    const std::string found = std::to_string(header->width) + "x" + std::to_string(header->height);
    const std::string expected = std::to_string(camera.width) + "x" + std::to_string(camera.height);
    if (&frame == &frames_.front())
      return Error{ErrorCode::invalid_argument, frame.path + " is " + found + " but camera.yaml says " + expected +
                                                    "; give the calibration of these pictures"};
    return Error{ErrorCode::invalid_argument, frame.path + " is " + found + ", expected " + expected +
                                                  " like the frames before it; keep one size to a folder"};
  }
  return Ok{};
}

Status FolderSource::read_timestamps(const std::string& path) {
  auto times = parse_times(path);
  if (!times) return times.error();
  for (Frame& frame : frames_) {
    const auto it = times->find(static_cast<std::int64_t>(frame.info.sequence));
    if (it == times->end())
      return Error{ErrorCode::corrupt, path + " has no row for " + frame.path + "; complete or delete the file"};
    frame.info.device_us = it->second.device_us;
    frame.info.host_ns = it->second.host_ns >= 0 ? it->second.host_ns : it->second.device_us * 1000;
  }
  return Ok{};
}

Status FolderSource::start() {
  index_ = 0;
  book_.reset();
  return Ok{};
}

Result<FrameInfo> FolderSource::next(DepthImage depth, int /*timeout_ms*/) {
  if (auto ok = path_.check(depth, info_.name); !ok) return ok.error();
  if (index_ >= frames_.size())
    return Error{ErrorCode::end_of_stream,
                 info_.name + ": all " + std::to_string(frames_.size()) + " frames were delivered"};
  const Frame& frame = frames_[index_++];
  Status status = read_into(frame.path, SIZE_MAX, file_bytes_);
  if (status) status = decode_depth(file_bytes_, frame.path, path_.camera_image());
  if (!status) {
    book_.damaged();
    return Error{ErrorCode::corrupt, status.error().message};
  }
  path_.deliver(depth);
  book_.saw(frame.info.sequence);
  return frame.info;
}

}  // namespace im2fit::hal
