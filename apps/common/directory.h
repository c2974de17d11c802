// SPDX-License-Identifier: Apache-2.0
// A directory held open: to sync what was renamed in it, or to lock it against other programs of ours.
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <string>
#include <utility>

namespace im2fit {

class Directory {
 public:
  explicit Directory(const std::string& path)
      : fd_(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW)) {}
  ~Directory() {
    if (fd_ >= 0) ::close(fd_);
  }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;

  // Until it is closed: the lock of a program that was killed is free. False leaves errno.
  bool lock() const { return fd_ >= 0 && ::flock(fd_, LOCK_EX) == 0; }
  bool lock_if_free() const { return fd_ >= 0 && ::flock(fd_, LOCK_EX | LOCK_NB) == 0; }
  bool sync() const { return fd_ >= 0 && ::fsync(fd_) == 0; }
  int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

}  // namespace im2fit
