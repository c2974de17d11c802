// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/status.h"

namespace im2fit::hal {

// A new folder that its owner alone can read. It is removed with this object, and when the process ends without that
// (a signal, kill -9): a shell waits for the end of a pipe. Without a shell, or when it is killed at the same time,
// only the first holds.
class TemporaryFolder {
 public:
  // Errors: io.
  static Result<TemporaryFolder> make();
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();
  const std::string& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}
  void watch();

  std::string path_;  // empty: moved from
  int pipe_ = -1;
  int watcher_ = -1;
};

}  // namespace im2fit::hal
