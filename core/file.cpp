// SPDX-License-Identifier: Apache-2.0
#include "core/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <ctime>
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

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

// Reads up to `count` bytes; fewer when the file ends, -1 on an error.
ssize_t read_all(int fd, std::byte* to, std::size_t count) {
  std::size_t done = 0;
  while (done < count) {
    const ssize_t n = ::read(fd, to + done, count - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return static_cast<ssize_t>(done);
}

// The one way a file is opened for reading. O_NONBLOCK: to open a FIFO would wait for its writer; regular files do
// not care.
int open_to_read(const std::string& path) {
  return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
}

Result<std::size_t> regular_size(int fd, const std::string& path) {
  struct stat about {};
  if (::fstat(fd, &about) != 0 || !S_ISREG(about.st_mode))
    return Error{ErrorCode::io, path + " is not a regular file"};
  if (static_cast<std::uint64_t>(about.st_size) > SIZE_MAX)  // 4 GiB and more on a 32-bit machine
    return Error{ErrorCode::unsupported, path + " is too large for this machine"};
  return static_cast<std::size_t>(about.st_size);
}

constexpr std::size_t kSuffixLetters = 6;
constexpr const char kLetters[] = "abcdefghijklmnopqrstuvwxyz0123456789";

// A new file beside `path`. O_EXCL follows no link that was put in its place.
int create_beside(const std::string& path, mode_t mode, std::string& temporary) {
  static std::atomic<std::uint64_t> made{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    std::uint64_t draw = static_cast<std::uint64_t>(::getpid()) * 0x9E3779B97F4A7C15U ^
                         (static_cast<std::uint64_t>(now.tv_nsec) + made++ * 0xD1B54A32D192ED03U);
    temporary = path + ".";
    for (std::size_t i = 0; i < kSuffixLetters; ++i, draw /= sizeof kLetters - 1)
      temporary += kLetters[draw % (sizeof kLetters - 1)];
    const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
  return -1;
}

}  // namespace

Status read_file_into(const std::string& path, std::size_t size_max, std::size_t count,
                      std::vector<std::byte>& bytes) {
  const Descriptor file(open_to_read(path));
  if (file.get() < 0) return system_error("cannot open", path);
  const auto size = regular_size(file.get(), path);
  if (!size) return size.error();
  if (*size > size_max)
    return Error{ErrorCode::unsupported,
                 path + " has " + std::to_string(*size) + " bytes, expected at most " + std::to_string(size_max)};
  bytes.resize(std::min(count, *size));
  const ssize_t read = read_all(file.get(), bytes.data(), bytes.size());
  if (read < 0) return system_error("cannot read", path);
  bytes.resize(static_cast<std::size_t>(read));
  return Ok{};
}

Result<std::vector<std::byte>> read_file(const std::string& path, std::size_t size_max) {
  std::vector<std::byte> bytes;
  if (auto done = read_file_into(path, size_max, SIZE_MAX, bytes); !done) return done.error();
  return bytes;
}

Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes, Readable readable) {
  std::string temporary;
  const int fd = create_beside(path, readable == Readable::by_owner ? 0600 : 0666, temporary);
  if (fd < 0) return system_error("cannot create a file beside", path);
  const bool written = write_all(fd, bytes) && ::fsync(fd) == 0;
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

Status write_file_atomically(const std::string& path, const std::string& text, Readable readable) {
  return write_file_atomically(path, std::as_bytes(std::span(text)), readable);
}

bool is_temporary_of(const std::string& name, const std::string& final_name) {
  return name.size() == final_name.size() + 1 + kSuffixLetters && name.rfind(final_name + ".", 0) == 0 &&
         name.find_first_not_of(kLetters, final_name.size() + 1) == std::string::npos;
}

Status make_directory(const std::string& path) {
  std::error_code code;
  std::filesystem::create_directories(path, code);
  if (code) return Error{ErrorCode::io, "cannot make the directory " + path + ": " + code.message()};
  if (!std::filesystem::is_directory(path, code))
    return Error{ErrorCode::io, path + " exists and is not a directory"};
  if (::access(path.c_str(), W_OK) != 0) return system_error("cannot write into", path);
  return Ok{};
}

Result<MappedFile> MappedFile::open(const std::string& path) {
  const Descriptor opened(open_to_read(path));
  if (opened.get() < 0) return system_error("cannot open", path);
  const auto size = regular_size(opened.get(), path);
  if (!size) return size.error();
  MappedFile file;
  if (*size == 0) return file;
  const bool copied = *size <= kCopiedMax;
  // All of a copy is written: its pages are made in one go, at a tenth of the cost of a fault for each.
  void* address =
      copied ? ::mmap(nullptr, *size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0)
             : ::mmap(nullptr, *size, PROT_READ, MAP_PRIVATE, opened.get(), 0);
  if (address == MAP_FAILED) return system_error("cannot map", path);
  file.data_ = static_cast<const std::byte*>(address);
  file.size_ = *size;
  if (!copied) return file;
  const ssize_t read = read_all(opened.get(), static_cast<std::byte*>(address), *size);
  if (read < 0) return system_error("cannot read", path);
  if (static_cast<std::size_t>(read) != *size)
    return Error{ErrorCode::io, path + " became shorter while it was read; replace it by a rename"};
  ::mprotect(address, *size, PROT_READ);
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
