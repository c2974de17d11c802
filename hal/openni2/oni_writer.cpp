// SPDX-License-Identifier: Apache-2.0
#include "hal/openni2/oni_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <utility>

#include "core/crc32c.h"
#include "core/file.h"
#include "hal/intrinsics.h"

namespace im2fit::hal {
namespace {

constexpr std::size_t kFramesPerSync = 30;  // a second's: more often costs time, less often frames when power fails
constexpr std::int64_t kFrame_us = 33'333;
// What a reader can turn into nanoseconds.
constexpr std::int64_t kTimeMax_us = std::numeric_limits<std::int64_t>::max() / 1000;
constexpr std::uint64_t kNumberMax = std::numeric_limits<std::int32_t>::max();  // the runtime counts frames in an int

// The line with the checksum, and a placeholder of the same length: the checksum is written in place, which works
// even on a full disk.
std::string checksum_line(std::uint32_t crc) {
  char line[48];
  std::snprintf(line, sizeof line, "im2fit_oni_crc32c: \"%08x\"\n", crc);
  return line;
}
std::string no_checksum_line() {
  std::string line = "# was never closed";
  line.resize(checksum_line(0).size() - 1, ' ');
  return line + "\n";
}

bool is_full(int code) {
  return code == ENOSPC || code == EFBIG || code == EDQUOT;
}

int sync(int fd) {
  return ::fdatasync(fd) == 0 ? 0 : errno;
}

// Frames a second, of the numbers that would have come.
int rate_of(const oni::FrameEntry& first, const oni::FrameEntry& last) {
  if (last.time_us <= first.time_us) return 30;
  const double rate = 1e6 * (last.number - first.number) / static_cast<double>(last.time_us - first.time_us);
  return static_cast<int>(std::lround(std::clamp(rate, 1.0, 1000.0)));
}

}  // namespace

std::string oni_sidecar_path(const std::string& oni_path) {
  return oni_path + ".yaml";
}

// In pieces: a recording may be larger than what a 32-bit machine can map.
Result<std::uint32_t> oni_crc32c(const std::string& oni_path) {
  const int fd = ::open(oni_path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return Error{ErrorCode::io, "cannot open " + oni_path + ": " + std::strerror(errno)};
  std::vector<std::byte> piece(std::size_t{1} << 18);
  std::uint32_t crc = 0;
  ssize_t count = 0;
  while ((count = ::read(fd, piece.data(), piece.size())) > 0 || (count < 0 && errno == EINTR))
    if (count > 0) crc = crc32c(std::span(piece).first(static_cast<std::size_t>(count)), crc);
  const int code = errno;
  ::close(fd);
  if (count < 0) return Error{ErrorCode::io, "cannot read " + oni_path + ": " + std::strerror(code)};
  return crc;
}

Result<std::unique_ptr<OniWriter>> OniWriter::create(const std::string& path, const Intrinsics& intrinsics,
                                                     const Options& options) {
  if (auto ok = check_intrinsics(intrinsics, "frames to write to " + path); !ok) return ok.error();
  const auto pixels = static_cast<std::size_t>(intrinsics.width) * static_cast<std::size_t>(intrinsics.height);
  if (2 * pixels > oni::kPayloadBytesMax)
    return Error{ErrorCode::unsupported, path + ": OpenNI2 plays pictures of up to " +
                                             std::to_string(oni::kPayloadBytesMax / 2) + " pixels, these have " +
                                             std::to_string(pixels) + "; record to a folder instead"};
  std::unique_ptr<OniWriter> writer(new OniWriter(path, intrinsics, options));
  if (auto ok = writer->open(); !ok) return ok.error();
  return writer;
}

OniWriter::OniWriter(const std::string& path, const Intrinsics& intrinsics, const Options& options)
    : path_(path), part_(path + ".part"), intrinsics_(intrinsics), options_(options) {
  head_.width = intrinsics.width;
  head_.height = intrinsics.height;
  head_.view = field_of_view(intrinsics);
  head_.camera_name = options.camera_name;
}

OniWriter::~OniWriter() {
  (void)finish();
}

Error OniWriter::failed(const std::string& what, const std::string& path, int code) const {
  return {ErrorCode::io, "cannot " + what + " " + path + ": " + std::strerror(code) +
                             "; free some space, or choose a folder you may write to"};
}

Status OniWriter::open() {
  fd_ = ::open(part_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd_ < 0) {
    if (errno != EEXIST) return failed("write", path_, errno);
    return Error{ErrorCode::invalid_argument,
                 part_ +
                     " is there: a recording that was never closed, or that is being made; rename it to .oni, "
                     "delete it or choose another name"};
  }
  const std::string calibration =
      camera_yaml_text(Calibration{intrinsics_, {}, 0, options_.origin}, options_.camera_name);
  checksum_at_ = calibration.size();
  if (auto ok = write_file_atomically(oni_sidecar_path(part_), calibration + no_checksum_line(), Readable::by_owner);
      !ok) {
    remove();
    return ok;
  }
  const oni::Bytes head = oni::head(head_);
  if (const int code = write_at(head, 0); code != 0) {
    remove();
    return failed("write", path_, code);
  }
  size_ = head.size();
  return Ok{};
}

void OniWriter::remove() {
  ::close(std::exchange(fd_, -1));
  ::unlink(part_.c_str());
  ::unlink(oni_sidecar_path(part_).c_str());
}

// 0 or what went wrong, with no byte beyond size_ then.
int OniWriter::write_at(std::span<const std::byte> bytes, std::uint64_t at) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const int code = count < 0 ? errno : ENOSPC;
      [[maybe_unused]] const int cut = ::ftruncate(fd_, static_cast<off_t>(size_));
      return code;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    at += static_cast<std::uint64_t>(count);
  }
  return 0;
}

oni::FrameEntry OniWriter::entry(const FrameInfo& info) const {
  std::int64_t time_us = device_clock_ ? info.device_us : info.host_ns / 1000;
  if (frames_.empty())
    return {1, static_cast<std::uint64_t>(std::clamp<std::int64_t>(time_us, 0, kTimeMax_us)), size_};
  const oni::FrameEntry& last = frames_.back();
  // A device whose counter restarts is numbered on; its own gaps stay.
  const std::uint64_t step = info.sequence > last_sequence_ ? info.sequence - last_sequence_ : 1;
  const auto last_us = static_cast<std::int64_t>(last.time_us);
  if (time_us <= last_us || time_us > kTimeMax_us) time_us = last_us + kFrame_us;
  return {step <= kNumberMax - last.number ? last.number + static_cast<std::uint32_t>(step) : last.number + 1,
          static_cast<std::uint64_t>(time_us), size_};
}

Status OniWriter::write(DepthView frame, const FrameInfo& info) {
  if (fd_ < 0) return Error{ErrorCode::invalid_argument, path_ + " is closed"};
  if (frame.width != intrinsics_.width || frame.height != intrinsics_.height)
    return Error{ErrorCode::invalid_argument,
                 path_ + ": frame to write is " + std::to_string(frame.width) + "x" + std::to_string(frame.height) +
                     ", expected " + std::to_string(intrinsics_.width) + "x" + std::to_string(intrinsics_.height)};
  if (frames_.empty()) device_clock_ = info.device_us >= 0;
  const oni::FrameEntry next = entry(info);
  oni::begin_frame(record_, next, frames_.empty() ? 0 : frames_.back().at);
  const std::size_t fields_bytes = record_.size();
  if (!encoder_.encode(frame, record_) || record_.size() - fields_bytes > oni::kPayloadBytesMax)
    return Error{ErrorCode::unsupported, path_ + ": a picture has more than " +
                                             std::to_string(OniEncoder::kValuesMax) +
                                             " different depths or is larger than OpenNI2 plays; record to a folder "
                                             "instead"};
  oni::finish_frame(record_);
  if (const int code = write_at(record_, size_); code != 0) return failed("write", path_, code);
  size_ += record_.size();
  frames_.push_back(next);
  last_sequence_ = info.sequence;
  if (frames_.size() % kFramesPerSync != 0) return Ok{};
  const int code = sync(fd_);
  return code == 0 ? Status(Ok{}) : failed("write", path_, code);
}

Status OniWriter::finish() {
  if (fd_ < 0) return Ok{};
  if (frames_.empty()) {
    remove();
    return Error{ErrorCode::io, path_ + " was not made: not one frame came"};
  }
  const std::uint64_t accepted = frames_.size();
  auto closed = close_file();
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  if (!closed) return closed;
  if (auto ok = put_in_place(); !ok) return ok;
  if (frames_.size() == accepted) return Ok{};
  return Error{ErrorCode::io, "the disk is full: the last " + std::to_string(accepted - frames_.size()) +
                                  " frames of " + path_ + " made room for closing it; free some space"};
}

// The tail first, then the head in one write: whenever that ends, the file is one or the other.
Status OniWriter::close_file() {
  if (auto ok = write_tail(); !ok) return ok;
  head_.fps = rate_of(frames_.front(), frames_.back());
  head_.frame_number_max = frames_.back().number;
  head_.time_min_us = frames_.front().time_us;
  head_.time_max_us = frames_.back().time_us;
  if (const int code = write_at(oni::head(head_), 0); code != 0) return failed("write", part_, code);
  if (const int code = sync(fd_); code != 0) return failed("write", part_, code);
  return write_checksum();
}

Status OniWriter::write_tail() {
  for (;;) {
    const oni::Tail tail = oni::tail(frames_, size_);
    const int code = write_at(tail.bytes, size_);
    if (code == 0) {
      head_.seek_table_at = tail.seek_table_at;
      size_ += tail.bytes.size();
      return Ok{};
    }
    if (!is_full(code) || frames_.size() == 1) return failed("write", part_, code);
    size_ = frames_.back().at;
    frames_.pop_back();
    if (::ftruncate(fd_, static_cast<off_t>(size_)) != 0) return failed("write", part_, errno);
  }
}

Status OniWriter::write_checksum() {
  const auto crc = oni_crc32c(part_);
  if (!crc) return crc.error();
  const std::string line = checksum_line(*crc);
  const std::string path = oni_sidecar_path(part_);
  const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) return failed("write", path, errno);
  const bool written =
      ::pwrite(fd, line.data(), line.size(), static_cast<off_t>(checksum_at_)) == static_cast<ssize_t>(line.size()) &&
      ::fdatasync(fd) == 0;
  const int code = errno;
  ::close(fd);
  if (!written) return failed("write", path, code);
  return Ok{};
}

Status OniWriter::put_in_place() {
  const std::string from[] = {oni_sidecar_path(part_), part_};
  const std::string to[] = {oni_sidecar_path(path_), path_};
  for (int i = 0; i < 2; ++i)
    if (std::rename(from[i].c_str(), to[i].c_str()) != 0) return failed("rename the recording to", to[i], errno);
  whole_ = true;
  return Ok{};
}

}  // namespace im2fit::hal
