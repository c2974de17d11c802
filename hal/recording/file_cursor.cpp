// SPDX-License-Identifier: Apache-2.0
#include "hal/recording/file_cursor.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace im2fit::hal {
namespace {

// Names and sizes of what follows are a few bytes; a picture is read past the buffer.
constexpr std::size_t kBufferBytes = 4096;

Error refused(const std::string& path, int error) {
  const ErrorCode code = error == ENOENT || error == ENOTDIR ? ErrorCode::not_found : ErrorCode::io;
  return {code, "cannot read " + path + ": " + std::strerror(error)};
}

}  // namespace

Result<FileCursor> FileCursor::open(const std::string& path) {
  FileCursor cursor{std::string(path)};
  // Without waiting: a FIFO would.
  cursor.fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (cursor.fd_ < 0) return refused(path, errno);
  struct stat about {};
  if (::fstat(cursor.fd_, &about) != 0) return refused(path, errno);
  if (!S_ISREG(about.st_mode)) return Error{ErrorCode::io, path + " is not a regular file"};
  cursor.size_ = static_cast<std::uint64_t>(about.st_size);
  return cursor;
}

FileCursor::FileCursor(std::span<const std::byte> bytes, std::string path)
    : path_(std::move(path)), bytes_(bytes), size_(bytes.size()) {}

FileCursor::FileCursor(FileCursor&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      bytes_(other.bytes_),
      size_(other.size_),
      at_(other.at_),
      buffer_(std::move(other.buffer_)),
      buffer_at_(other.buffer_at_) {}

FileCursor::~FileCursor() {
  if (fd_ >= 0) ::close(fd_);
}

Status FileCursor::read_at(std::uint64_t at, std::span<std::byte> out) const {
  if (fd_ < 0) {
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + at, out.size());
    return Ok{};
  }
  for (std::size_t have = 0; have < out.size();) {
    const auto got = ::pread(fd_, out.data() + have, out.size() - have, static_cast<off_t>(at + have));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return refused(path_, errno);
    if (got == 0) return Error{ErrorCode::io, path_ + " became shorter while it was read"};
    have += static_cast<std::size_t>(got);
  }
  return Ok{};
}

Status FileCursor::read(std::span<std::byte> out) {
  if (out.size() > left())
    return Error{ErrorCode::corrupt, path_ + " ends at byte " + std::to_string(size_) + ", within a record"};
  const bool buffered = at_ >= buffer_at_ && at_ - buffer_at_ + out.size() <= buffer_.size();
  if (!buffered && out.size() > kBufferBytes / 2) {
    if (auto ok = read_at(at_, out); !ok) return ok;
    at_ += out.size();
    return Ok{};
  }
  if (!buffered) {
    buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBufferBytes, left())));
    buffer_at_ = at_;
    if (auto ok = read_at(at_, buffer_); !ok) {
      buffer_.clear();
      return ok;
    }
  }
  if (!out.empty()) std::memcpy(out.data(), buffer_.data() + (at_ - buffer_at_), out.size());
  at_ += out.size();
  return Ok{};
}

}  // namespace im2fit::hal
