// SPDX-License-Identifier: Apache-2.0
#include "core/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace im2fit {
namespace {

Error system_error(const std::string& what, const std::string& path) {
  const int code = errno;
  return {code == ENOENT ? ErrorCode::not_found : ErrorCode::io, what + " " + path + ": " + std::strerror(code)};
}

bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0) {
      if (errno == EINTR) continue;
      return false;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

Result<std::vector<std::byte>> read_file(const std::string& path) {
  auto mapped = MappedFile::open(path);
  if (!mapped) return mapped.error();
  const auto bytes = mapped->bytes();
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  std::string temporary = path + ".XXXXXX";
  const int fd = ::mkstemp(temporary.data());
  if (fd < 0) return system_error("cannot create a file beside", path);
  const bool written = write_all(fd, bytes) && ::fsync(fd) == 0 && ::fchmod(fd, 0644) == 0;
  Error error;
  if (!written) error = system_error("cannot write", path);
  const bool closed = ::close(fd) == 0;
  if (written && !closed) error = system_error("cannot write", path);
  if (!written || !closed || ::rename(temporary.c_str(), path.c_str()) != 0) {
    if (written && closed) error = system_error("cannot rename a new file to", path);
    ::unlink(temporary.c_str());
    return error;
  }
  return Ok{};
}

Status write_file_atomically(const std::string& path, const std::string& text) {
  return write_file_atomically(path, std::as_bytes(std::span(text)));
}

Status make_directory(const std::string& path) {
  std::error_code code;
  std::filesystem::create_directories(path, code);
  if (code) return Error{ErrorCode::io, "cannot make the directory " + path + ": " + code.message()};
  if (!std::filesystem::is_directory(path)) return Error{ErrorCode::io, path + " exists and is not a directory"};
  if (::access(path.c_str(), W_OK) != 0) return system_error("cannot write into", path);
  return Ok{};
}

Result<MappedFile> MappedFile::open(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return system_error("cannot open", path);
  struct stat info {};
  if (::fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
    ::close(fd);
    return Error{ErrorCode::io, path + " is not a regular file"};
  }
  MappedFile file;
  file.size_ = static_cast<std::size_t>(info.st_size);
  if (file.size_ > 0) {
    void* address = ::mmap(nullptr, file.size_, PROT_READ, MAP_PRIVATE, fd, 0);
    if (address == MAP_FAILED) {
      file.size_ = 0;
      Error error = system_error("cannot map", path);
      ::close(fd);
      return error;
    }
    file.data_ = static_cast<const std::byte*>(address);
  }
  ::close(fd);
  return file;
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

}  // namespace im2fit
