// SPDX-License-Identifier: Apache-2.0
// A large file read from front to back with jumps, through one small buffer: memory does not grow with the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit::hal {

class FileCursor {
 public:
  // Regular files only. Errors: not_found, io.
  static Result<FileCursor> open(const std::string& path);
  // Bytes that outlive the cursor, in place of a file. `path` names them in errors.
  FileCursor(std::span<const std::byte> bytes, std::string path);
  FileCursor(FileCursor&& other) noexcept;
  FileCursor& operator=(FileCursor&&) = delete;
  FileCursor(const FileCursor&) = delete;
  FileCursor& operator=(const FileCursor&) = delete;
  ~FileCursor();

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  std::uint64_t at() const { return at_; }
  std::uint64_t left() const { return size_ - at_; }
  void seek(std::uint64_t at) { at_ = at < size_ ? at : size_; }
  // Fills all of `out`. Errors: corrupt (the file ends before; nothing was read), io.
  Status read(std::span<std::byte> out);

 private:
  explicit FileCursor(std::string path) : path_(std::move(path)) {}
  Status read_at(std::uint64_t at, std::span<std::byte> out) const;

  std::string path_;
  int fd_ = -1;  // -1: bytes_ are read
  std::span<const std::byte> bytes_;
  std::uint64_t size_ = 0, at_ = 0;
  std::vector<std::byte> buffer_;
  std::uint64_t buffer_at_ = 0;  // where in the file buffer_ begins
};

}  // namespace im2fit::hal
